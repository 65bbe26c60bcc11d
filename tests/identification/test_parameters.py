"""A vehicle file of what PX4 knows: every vehicle gets one that is accepted, and every guess is marked."""

from __future__ import annotations

import math

import pytest

from companion.config.syntax.document import parse
from companion.config.vehicle import load_vehicle, vehicle_from
from companion.identification.description import Source, of_file
from companion.identification.parameters import describe_parameters
from companion.vehicle import CompanionError, Spin, Vehicle
from companion.world import Home
from sim_bridge.autopilot.parameters import of

REAL = {
    "SYS_AUTOSTART": 4014, "CA_AIRFRAME": 0, "CA_ROTOR_COUNT": 4, "MPC_THR_HOVER": 0.39, "THR_MDL_FAC": 0.3,
    "MC_ROLLRATE_P": 0.12, "MC_ROLLRATE_D": 0.002, "MC_PITCHRATE_P": 0.14, "MC_PITCHRATE_D": 0.002,
    "MC_YAWRATE_MAX": 200.0, "MPC_TILTMAX_AIR": 35.0, "FD_FAIL_R": 0, "FD_FAIL_P": 0, "COM_OF_LOSS_T": 0.3,
    **{f"CA_ROTOR{i}_P{a}": v for i, p in enumerate(((0.15, 0.2, -0.02), (-0.15, -0.2, -0.02), (0.15, -0.2, -0.02), (-0.15, 0.2, -0.02))) for a, v in zip("XYZ", p, strict=True)},
    **{f"CA_ROTOR{i}_KM": km for i, km in enumerate((0.05, 0.05, -0.05, -0.05))},
}  # fmt: skip


def made(values: dict[str, float], **measured: float) -> tuple[str, Vehicle]:
    text = describe_parameters(values, name="mine", origin=("of PX4",), **measured).text  # type: ignore[arg-type]
    return text, vehicle_from(parse(text, "mine.yaml"))


@pytest.mark.parametrize("name", ["sih", "x500"])
def test_px4s_simulation_describes_itself_fully(name: str) -> None:
    true = load_vehicle(name)
    text, vehicle = made(of(true, Home()))
    assert "MEASURE" not in text
    assert vehicle.mass == pytest.approx(true.mass) and vehicle.inertia == pytest.approx(true.inertia, rel=1e-3)
    for told, rotor in zip(vehicle.rotors, true.rotors, strict=True):
        assert told.position_b == pytest.approx(rotor.position_b, rel=1e-3) and told.spin is rotor.spin
        assert told.thrust_max == pytest.approx(rotor.thrust_max, rel=1e-3)
        assert told.torque_per_thrust == pytest.approx(rotor.torque_per_thrust, rel=1e-3)
    assert vehicle.drag == pytest.approx(true.drag) and vehicle.motor_lag == pytest.approx(true.motor_lag)
    if name == "sih":  # measured on PX4: 71 ms
        assert vehicle.rate_loop_lag == pytest.approx(0.071, rel=0.2)


def test_a_real_frame_is_told_what_is_to_be_measured() -> None:
    text, vehicle = made(REAL)
    assert vehicle.rotors[0].position_b == (0.15, 0.2, -0.02) and vehicle.rotors[2].spin is Spin.CW
    assert vehicle.hover_thrust == 0.39 and vehicle.thrust_max == pytest.approx(vehicle.weight / 0.39, rel=1e-3)
    assert vehicle.limits is not None
    assert math.degrees(vehicle.limits.tilt) == pytest.approx(35.0)
    assert math.degrees(vehicle.limits.failure_detector) == pytest.approx(180.0)
    for line in text.splitlines():
        if line.startswith(("mass_kg", "inertia_kgm2", "motor_lag_s")):
            assert "# MEASURE: " in line
    assert "COM_OF_LOSS_T 0.3" in text and "THR_MDL_FAC 0.3" in text and "uid" not in text


def test_what_the_user_measured_is_taken() -> None:
    text, vehicle = made(
        {
            **REAL,
            **{f"CA_ROTOR{i}_P{a}": math.copysign(1.0, REAL[f"CA_ROTOR{i}_P{a}"]) for i in range(4) for a in "XY"},
        },
        mass=1.45,
        arm=0.28,
    )
    assert "mass_kg: 1.45 # given: kg" in text
    assert max(math.hypot(*rotor.position_b[:2]) for rotor in vehicle.rotors) == pytest.approx(0.28, rel=1e-3)
    text, _ = made(
        {**REAL, **{f"CA_ROTOR{i}_P{a}": math.copysign(1.0, REAL[f"CA_ROTOR{i}_P{a}"]) for i in range(4) for a in "XY"}}
    )
    assert "the shape only" in text


def test_a_comment_belongs_to_its_line() -> None:
    """Whoever takes one away makes no other value a guess or a fact."""
    text, _ = made(REAL)
    lines = text.splitlines()
    rotor, limit = lines.index("rotors:") + 1, lines.index("limits:") + 1
    name = lines[limit].split(":")[0].strip()
    for i in (rotor, limit):
        lines[i] = lines[i].split(" #")[0]
    read = [(parse(each, "mine.yaml"), each) for each in (text, "\n".join(lines))]
    before, after = (dict(of_file(file.data, file.lines, each).entries) for file, each in read)
    for entry in (after["rotors"].pop(0), after["limits"].pop(name)):
        assert entry.source is Source.GIVEN and entry.words == ""
    assert before["rotors"].pop(0).source is not Source.GIVEN and before["limits"].pop(name).source is not Source.GIVEN
    assert after == before


def test_an_old_px4_without_geometry_still_gives_a_file() -> None:
    text, vehicle = made({"MPC_THR_HOVER": 0.5})
    guessed = "# MEASURE: PX4 says nothing of its rotors (no CA_ROTOR*); a quad X is assumed, its arm 0.25 m; measure"
    assert guessed in text and "shape only" not in text
    assert max(math.hypot(*r.position_b) for r in vehicle.rotors) == pytest.approx(0.25, rel=1e-3)
    assert [rotor.spin for rotor in vehicle.rotors] == [Spin.CCW, Spin.CCW, Spin.CW, Spin.CW]


@pytest.mark.parametrize("change", [{"CA_ROTOR_COUNT": 6}, {"CA_AIRFRAME": 1}, {"CA_ROTOR2_AZ": 0.0}])
def test_other_vehicles_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(CompanionError, match=r"no quadrotor|tilted"):
        describe_parameters({**REAL, **change}, name="mine")


@pytest.mark.parametrize(
    ("kind", "name"),
    [(1, "fixed wing"), (10, "rover"), (13, "hexarotor"), (14, "octorotor"), (15, "tricopter"), (29, "dodecarotor"),
     *((vtol, "VTOL") for vtol in range(19, 26)), (77, "another vehicle")],
)  # fmt: skip
def test_an_old_px4_says_by_mav_type_what_it_flies(kind: int, name: str) -> None:
    """Up to 1.13 there are no CA_*: a VTOL with four lifting rotors would be taken for a quad X."""
    with pytest.raises(CompanionError, match=f"no quadrotor \\(MAV_TYPE {kind}: {name}\\); nothing was written"):
        describe_parameters({"MPC_THR_HOVER": 0.5, "MAV_TYPE": kind}, name="mine")


@pytest.mark.parametrize("kind", [0, 2])
def test_an_old_px4_that_flies_a_quadrotor_gives_a_file(kind: int) -> None:
    assert len(made({"MPC_THR_HOVER": 0.5, "MAV_TYPE": kind})[1].rotors) == 4


@pytest.mark.parametrize("more", [{"CA_SV_CS_COUNT": 5}, {"CA_ROTOR4_PX": 0.2}])
def test_what_no_quadrotor_has_is_refused_where_only_what_was_changed_is_told(more: dict[str, float]) -> None:
    changed = {name: value for name, value in REAL.items() if name not in ("CA_AIRFRAME", "CA_ROTOR_COUNT")}
    assert len(made(changed)[1].rotors) == 4
    with pytest.raises(CompanionError, match=r"control surfaces|more than four rotors"):
        describe_parameters({**changed, **more}, name="mine")


def test_control_surfaces_that_an_airframe_does_not_use_are_no_matter() -> None:
    assert len(made({**REAL, "CA_SV_CS_COUNT": 2, "MAV_TYPE": 22})[1].rotors) == 4


def test_what_an_incomplete_set_lacks_is_as_px4_ships_it() -> None:
    """Files of parameters often hold only what was changed."""
    lacking = {name: value for name, value in REAL.items() if not name.endswith(("_PZ", "_KM"))}
    text, vehicle = made(lacking)
    assert [rotor.position_b[2] for rotor in vehicle.rotors] == [0.0] * 4
    assert [rotor.spin for rotor in vehicle.rotors] == [Spin.CCW, Spin.CCW, Spin.CW, Spin.CW]
    assert "# MEASURE: CA_ROTOR*_PX, PY, PZ; spins of a quad X assumed (no CA_ROTOR*_KM)" in text


@pytest.mark.parametrize("missing", ["SIH_T_TAU", "SIH_IZZ", "SIH_L_ROLL"])
def test_a_simulation_that_tells_half_of_its_machine_is_guessed_as_any_vehicle(missing: str) -> None:
    values = dict(of(load_vehicle("sih"), Home()))
    del values[missing]
    text, _ = made(values)
    assert "mass_kg" in text and "# MEASURE: kg; guessed" in text


def test_no_gap_of_a_set_of_parameters_is_a_crash() -> None:
    """Whatever is missing, there is a file that says so, or a word on what is wrong."""
    for values in (REAL, dict(of(load_vehicle("sih"), Home()))):
        for name in values:
            if name.startswith(("CA_", "SIH_", "MPC_", "MC_", "FD_", "SYS_")):
                made({other: value for other, value in values.items() if other != name})
