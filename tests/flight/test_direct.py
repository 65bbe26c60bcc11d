"""Past PX4's rate loop: what must be the same, what must be set, what must be known."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.flight.conduct import Conduct, Limits, caught
from companion.flight.geometry import curve_words, differences, names
from companion.flight.output import chosen, direct_refused
from companion.vehicle import CompanionError, OutputLevel, Rotor, Spin, Tuning, Vehicle
from companion.vehicle import Limits as VehicleLimits

QUAD = Vehicle(
    "quad", 1.0, (0.02, 0.02, 0.04),
    tuple(
        Rotor((0.2 * x, 0.2 * y, 0.0), spin, 5.0, 0.02)
        for x, y, spin in ((1, 1, Spin.CCW), (-1, -1, Spin.CCW), (1, -1, Spin.CW), (-1, 1, Spin.CW))
    ),
)  # fmt: skip
AIRFRAME: dict[str, float | None] = {"CA_ROTOR_COUNT": 4.0, "THR_MDL_FAC": 0.0}
for n, (x, y, km) in enumerate(((1, 1, 0.05), (-1, -1, 0.05), (1, -1, -0.05), (-1, 1, -0.05))):
    AIRFRAME |= {f"CA_ROTOR{n}_PX": float(x), f"CA_ROTOR{n}_PY": float(y), f"CA_ROTOR{n}_KM": km}
PX4 = Tuning(offboard_loss_time=1.0, offboard_loss_action=0)


def test_an_airframe_that_gives_only_its_shape_agrees() -> None:
    assert set(names(QUAD)) == set(AIRFRAME)
    assert differences(QUAD, AIRFRAME) == []


def test_what_differs_is_named() -> None:
    other = AIRFRAME | {"CA_ROTOR1_PX": -2.0, "CA_ROTOR2_KM": 0.05}
    sits, turns = differences(QUAD, other)
    assert "motor 2 sits at (-2, -1) by CA_ROTOR1_PX and _PY, and at (-0.2, -0.2) by the vehicle file" in sits
    assert turns == "motor 3 turns ccw by CA_ROTOR2_KM, and cw by the vehicle file"
    swapped = AIRFRAME | {"CA_ROTOR0_PY": -1.0, "CA_ROTOR2_PY": 1.0}
    assert [words.split(" sits")[0] for words in differences(QUAD, swapped)] == ["motor 1", "motor 3"]
    assert differences(QUAD, AIRFRAME | {"CA_ROTOR_COUNT": 6.0}) == [
        "PX4 has 6 rotors (CA_ROTOR_COUNT), quad has 4"
    ]  # fmt: skip
    assert "does not say CA_ROTOR3_KM" in differences(QUAD, AIRFRAME | {"CA_ROTOR3_KM": None})[0]
    assert "THR_MDL_FAC is 0" in curve_words(AIRFRAME)
    assert "does not say THR_MDL_FAC" in curve_words(AIRFRAME | {"THR_MDL_FAC": None})
    assert "share of thrust, as the vehicle file" in curve_words({"THR_MDL_FAC": 0.3})


@pytest.mark.parametrize("level", [OutputLevel.MOTORS, OutputLevel.TORQUES])
def test_a_tenth_of_a_second_and_hold_or_not_at_all(level: OutputLevel) -> None:
    choice = chosen(level, PX4, auto=False, consent=True, over_xrce=True)
    assert choice.settings == (("COM_OF_LOSS_T", 0.1), ("COM_OBL_RC_ACT", 5))
    with pytest.raises(CompanionError, match=r"COM_OF_LOSS_T is 1 s, .* expected Hold \(5\); set"):
        chosen(level, PX4, auto=False, consent=False, over_xrce=True)
    land = Tuning(offboard_loss_time=0.1, offboard_loss_action=4)  # good enough over MAVLink
    assert chosen(level, land, auto=False, consent=True, over_xrce=True).settings == (("COM_OBL_RC_ACT", 5),)
    ready = Tuning(offboard_loss_time=0.10000000149, offboard_loss_action=5)
    assert chosen(level, ready, auto=False, consent=False, over_xrce=True).settings == ()


def test_what_px4_no_longer_does_is_said_and_must_be_accepted() -> None:
    refused = direct_refused(QUAD, OutputLevel.MOTORS, accepted=False)
    assert refused is not None
    assert "failure detector does not look at the attitude" in refused
    assert "--accept-direct-motors" in refused
    assert direct_refused(QUAD, OutputLevel.MOTORS, accepted=True) is None
    assert direct_refused(QUAD, OutputLevel.RATES, accepted=False) is None


def test_a_vehicle_whose_motors_pull_stays_on_mavlink() -> None:
    """PX4 takes what is negative for "stop this motor". Rates and attitude are mixed by PX4 itself."""
    pulling = replace(QUAD, rotors=tuple(replace(rotor, command=(-1.0, 1.0)) for rotor in QUAD.rotors))
    assert "go below 0" in (direct_refused(pulling, OutputLevel.MOTORS, accepted=True) or "")
    assert direct_refused(pulling, OutputLevel.RATES, accepted=False) is None


def test_past_the_rate_loop_the_tilt_is_given_back_while_px4_can_catch_it() -> None:
    """PX4's Hold caught 49 and 51 degrees."""
    conduct = Conduct(limits=Limits(tilt=math.radians(58.0)))
    steep = replace(QUAD, limits=VehicleLimits(tilt=math.radians(50.0)))
    assert caught(conduct, QUAD).limits.tilt == pytest.approx(math.radians(50.0))
    assert caught(conduct, steep).limits.tilt == pytest.approx(math.radians(55.0))
    assert caught(Conduct(limits=Limits(tilt=math.radians(40.0))), steep).limits.tilt == pytest.approx(
        math.radians(40.0)
    )
    assert caught(conduct, replace(QUAD, limits=None)) == conduct
