"""What PX4 does with what is written to it over XRCE: measured on PX4 main of March 2026 in its own simulation."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.frames import rotation_matrix
from companion.mavlink.modes import Mode
from sim_bridge.plant import Truth
from tests.support.plant_client import ARM
from tests.support.xrce_agent import XrceClient, motors, offboard_mode, rates, thrust, torque

DIRECT = offboard_mode("direct_actuator")
OFFBOARD, ALLOCATION = 12, 20
"""Bytes of a vehicle_control_mode."""


def in_the_air(lost_after: float = 0.3) -> XrceClient:
    """In HOLD, the session stands, and hold is what follows the loss of offboard."""
    vehicle = XrceClient()
    vehicle.bridge.autopilot.parameters.update(COM_OF_LOSS_T=lost_after, COM_OBL_RC_ACT=5)
    vehicle.connect()
    return vehicle


def hover(vehicle: XrceClient) -> float:
    return vehicle.bridge.autopilot.cascade.hover


def tilt(truth: Truth) -> float:
    """Degrees from upright."""
    return math.degrees(math.acos(max(-1.0, min(1.0, rotation_matrix(truth.q_nb)[8]))))


def at_125_hz(write: Callable[[], None]) -> Callable[[], None]:
    count = [0]

    def step() -> None:
        count[0] += 1
        if count[0] % 2 == 0:
            write()

    return step


def test_control_mode_tells_who_flies() -> None:
    vehicle = in_the_air()
    vehicle.run(0.1)
    (_, held), *_ = vehicle.samples["vehicle_control_mode"][-1:]
    assert (held[OFFBOARD], held[ALLOCATION]) == (0, 1)
    vehicle.in_offboard(DIRECT)
    assert vehicle.flown is Mode.OFFBOARD
    at, sample = vehicle.samples["vehicle_control_mode"][-1]
    assert (sample[OFFBOARD], sample[ALLOCATION]) == (1, 0)
    assert vehicle.bridge.now - at < 0.06  # on change, not at the next half second
    vehicle.rates(thrust=hover(vehicle))  # MAVLink's receiver writes the same topic
    vehicle.run(0.06)
    assert vehicle.samples["vehicle_control_mode"][-1][1][ALLOCATION] == 1


@pytest.mark.parametrize(
    ("lost_after", "tilts"), [(0.1, (15.0, 30.0)), (0.3, (40.0, 75.0)), (1.0, (90.0, 180.0))],
    ids=["0.1 s", "0.3 s", "1 s is a crash"],
)  # fmt: skip
def test_motors_are_held_until_the_loss_is_noticed(lost_after: float, tilts: tuple[float, float]) -> None:
    """A process that dies 0.12 s into a sidestep: measured 20, 50 and 177 deg, Hold 0.08 s after COM_OF_LOSS_T.

    PX4 looks every 0.1 s; here the last command comes 0.04 s after a look.
    """
    vehicle = in_the_air(lost_after)
    share = hover(vehicle)
    vehicle.run((0.04 - 0.07 - 0.12 - vehicle.bridge.now) % 0.1)  # 0.07 s into OFFBOARD, 0.12 s aside
    vehicle.in_offboard(DIRECT, motors(*(share,) * 4))
    lean = 0.07  # each motor's share, to the right: about the tilts that were measured
    push = (share - lean, share + lean, share + lean, share - lean)
    vehicle.run(0.12, at_125_hz(lambda: vehicle.write(DIRECT, motors(*push), thrust(share))))
    height, worst = -vehicle.bridge.truth.p_n[2], [0.0]

    def look() -> None:
        if vehicle.flown is Mode.OFFBOARD:
            worst[0] = max(worst[0], tilt(vehicle.bridge.truth))

    took = 0.0
    while vehicle.flown is Mode.OFFBOARD:
        look()
        vehicle.step()
        took += vehicle.bridge.step_s
    assert took == pytest.approx(lost_after + 0.08, abs=0.012)
    assert vehicle.flown is Mode.HOLD
    print(f"{lost_after} s: {took:.3f} s, {worst[0]:.0f} deg")
    assert tilts[0] < worst[0] <= tilts[1]
    vehicle.run(3.0)
    lost = height + vehicle.bridge.truth.p_n[2]
    assert (lost < 3.0) if lost_after < 1.0 else (lost > 3.0 or vehicle.bridge.truth.on_ground)


def test_nothing_acts_while_the_mode_is_written_and_the_motors_are_not() -> None:
    vehicle = in_the_air()
    share = hover(vehicle)
    vehicle.in_offboard(DIRECT)
    vehicle.write(DIRECT, motors(share, share + 0.004, share, share))
    vehicle.run(4.0, at_125_hz(lambda: vehicle.write(DIRECT)))
    assert vehicle.flown is Mode.OFFBOARD
    assert tilt(vehicle.bridge.truth) > 30.0
    assert vehicle.bridge.autopilot.commander.armed  # the failure detector looks only while PX4 controls attitude


def test_its_own_hold_is_not_kept_from_motors_that_are_written() -> None:
    vehicle = in_the_air()
    height = -vehicle.bridge.truth.p_n[2]
    vehicle.run(1.5, at_125_hz(lambda: vehicle.write(motors(0.0, 0.0, 0.0, 0.0))))
    assert vehicle.flown is Mode.HOLD
    assert 0.2 < height + vehicle.bridge.truth.p_n[2] < 2.0  # measured: 0.6 m
    vehicle.run(4.0)
    assert -vehicle.bridge.truth.p_n[2] == pytest.approx(height, abs=0.3)


def test_disarming_and_termination_are_behind_the_motors_that_are_written() -> None:
    for command, parameters in ((ARM, (0.0, 21196.0)), (185, (1.0,))):
        vehicle = in_the_air()
        vehicle.in_offboard(DIRECT, motors(*(hover(vehicle),) * 4))
        assert vehicle.command(command, *parameters) == 0
        vehicle.run(0.5, at_125_hz(lambda v=vehicle: v.write(DIRECT, motors(1.0, 1.0, 1.0, 1.0))))  # type: ignore[misc]
        assert vehicle.bridge.truth.thrust < 0.1


@pytest.mark.parametrize("says", [False, True], ids=["nobody says the thrust", "the thrust is written along"])
def test_it_believes_it_has_landed_where_nobody_says_the_thrust(says: bool) -> None:
    """Up from the ground on motors alone, then standing still in the air. Measured: disarmed at 6.2 m."""
    vehicle = XrceClient(landed=True)
    vehicle.bridge.autopilot.parameters.update(COM_OF_LOSS_T=0.3, COM_OBL_RC_ACT=5)
    vehicle.run(6.0)
    assert vehicle.client.serves
    share, bridge = hover(vehicle), vehicle.bridge
    vehicle.write(DIRECT, motors(0.0, 0.0, 0.0, 0.0))
    vehicle.run(0.02)
    assert vehicle.mode(Mode.OFFBOARD) == 0
    assert vehicle.command(ARM, 1) == 0

    def climb() -> None:
        up = share * (1.0 + 0.4 * (-4.0 - bridge.truth.p_n[2]) * -0.25 - 0.3 * -bridge.truth.v_n[2])
        vehicle.write(DIRECT, motors(*(max(0.0, min(1.0, up)),) * 4), *([thrust(up)] if says else []))

    vehicle.run(12.0, at_125_hz(climb))
    assert bridge.autopilot.commander.armed is says
    texts = [text for line in bridge.log for text in [line] if "Landing" in text]
    assert bool(texts) is not says


def test_torques_go_through_its_mixer_and_rates_through_its_loop() -> None:
    vehicle = in_the_air()
    share = hover(vehicle)
    vehicle.in_offboard(offboard_mode("thrust_and_torque"), thrust(share), torque(0.0, 0.0, 0.0))
    vehicle.write(offboard_mode("thrust_and_torque"), thrust(share), torque(0.02, 0.0, 0.01))
    vehicle.run(0.016)
    a, b, c, d = vehicle.bridge.autopilot.commands
    half = 0.02 / math.sqrt(2.0)  # of a torque about roll each motor of a quad X gets as much, about yaw all of it
    assert sorted((a, b, c, d)) == pytest.approx(
        sorted((share - half + 0.01, share + half + 0.01, share + half - 0.01, share - half - 0.01)), abs=1e-6
    )
    assert vehicle.samples["vehicle_control_mode"][-1][1][ALLOCATION] == 1
    spin = (offboard_mode("body_rate"), rates(0.0, 0.0, 0.5, share))
    vehicle.run(1.5, at_125_hz(lambda: vehicle.write(*spin)))
    assert vehicle.flown is Mode.OFFBOARD
    assert vehicle.bridge.truth.w_b[2] == pytest.approx(0.5, abs=0.1)


def test_a_mode_that_asks_for_nothing_or_is_old_does_not_count() -> None:
    vehicle = in_the_air()
    vehicle.run(2.0)
    for sample in (offboard_mode(""), offboard_mode("direct_actuator", stamp=1_000_000)):
        vehicle.write(sample)
        vehicle.run(0.02)
        assert vehicle.mode(Mode.OFFBOARD) == 1
    vehicle.write(offboard_mode("direct_actuator", stamp=1 << 60))  # the future is now
    vehicle.run(0.02)
    assert vehicle.mode(Mode.OFFBOARD) == 0
