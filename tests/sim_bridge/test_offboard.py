"""Arming, modes and offboard as PX4 does them: refusals, the stream rule, loss and return, who wins."""

from __future__ import annotations

import math

import pytest

from companion.frames import euler_from_rotation, quaternion_from_euler, rotation_matrix
from companion.mavlink.modes import Mode
from companion.world import Deviations, Start, World
from tests.support.plant_client import (  # fmt: skip
    ACCEPTED,
    ARM,
    LAND,
    NAN,
    RETURN,
    SET_MODE,
    TAKEOFF,
    TEMPORARILY_REJECTED,
    Client,
)

TURNING_AIR = World(truth=Deviations(angular_drag=0.025))
"""The air damps the turning, as in PX4's own simulation; without it yaw overshoots."""


def streaming(client: Client, hz: float = 50.0) -> object:
    """A call for every step that sends a hover setpoint at ``hz``."""
    every = round(1.0 / hz / client.bridge.step_s)
    count = [0]

    def each_step() -> None:
        if count[0] % every == 0:
            client.rates(thrust=client.bridge.autopilot.cascade.hover)
        count[0] += 1

    return each_step


def in_offboard(vehicle: str = "sih", **options: object) -> Client:
    client = Client(vehicle, **options)
    client.ground_station()
    client.rates(thrust=client.bridge.autopilot.cascade.hover)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    client.run(0.5, streaming(client))
    assert client.flown is Mode.OFFBOARD
    return client


def test_boot_refuses_to_arm_until_it_is_ready() -> None:
    client = Client("sih", landed=True)
    client.ground_station()
    client.run(0.8)
    assert not client.all("HEARTBEAT")
    client.run(3.4)
    assert client.last("HEARTBEAT")["system_status"] == 0
    assert client.last("HEARTBEAT")["base_mode"] == 0x1D
    assert client.command(ARM, 1) == TEMPORARILY_REJECTED
    assert client.texts() == ["Arming denied: Resolve system health failures first\t"]
    client.run(1.0)
    assert client.last("HEARTBEAT")["system_status"] == 3
    assert client.last("SYS_STATUS")["onboard_control_sensors_health"] & 0x10000000
    assert client.command(ARM, 1) == ACCEPTED
    assert client.texts()[-1] == "Armed by external command\t"
    client.run(1.0)
    heartbeat = client.last("HEARTBEAT")
    assert (heartbeat["base_mode"], heartbeat["system_status"], heartbeat["custom_mode"]) == (0x9D, 4, 0x03040000)
    assert client.command(ARM, 1) == ACCEPTED
    assert client.command(ARM, 0) == ACCEPTED
    assert client.command(ARM, 0) == ACCEPTED


def test_arming_without_a_take_off_ends_by_itself() -> None:
    client = Client("sih", landed=True)
    client.ground_station()
    client.run(5.0)
    client.command(ARM, 1)
    took = client.run_until(lambda: not client.bridge.autopilot.commander.armed, 12.0)
    assert took == pytest.approx(10.0, abs=0.05)
    assert client.texts()[-1] == "Disarmed by auto preflight disarming\t"


def test_arming_parameters() -> None:
    client = Client("sih")
    client.ground_station()
    assert client.command(ARM, 2) is None  # as PX4: a text, no answer
    assert client.texts()[-1] == "Unsupported ARM_DISARM param: 2.000\t"
    assert client.command(ARM, NAN) == TEMPORARILY_REJECTED  # no number is none: disarm
    assert client.command(ARM, 0) == TEMPORARILY_REJECTED
    assert client.texts()[-1] == "Disarming denied: not landed\t"
    assert client.command(ARM, 0, 21196) == ACCEPTED  # by force: the motors are cut
    client.run(0.5)
    assert client.bridge.truth.thrust < 0.01


def test_on_the_ground_any_mode_is_taken_and_the_refusal_comes_at_arming() -> None:
    client = Client("sih", landed=True)
    client.run(5.0)
    for mode in (Mode.OFFBOARD, Mode.POSITION, Mode.MANUAL, Mode.MISSION):
        assert client.mode(mode) == ACCEPTED
        assert client.flown is mode
        assert client.command(ARM, 1) == TEMPORARILY_REJECTED
    client.mode(Mode.OFFBOARD)
    client.rates(thrust=0.0)
    assert client.command(ARM, 1) == ACCEPTED


def test_in_the_air_a_mode_that_cannot_run_is_refused() -> None:
    client = Client("sih")
    client.ground_station()
    for mode, name in ((Mode.OFFBOARD, "Offboard"), (Mode.POSITION, "Position"), (Mode.MISSION, "Mission")):
        assert client.mode(mode, endpoint=1) == TEMPORARILY_REJECTED
        assert client.texts()[-1] == f"Switching to {name} is currently not available\t"
        assert client.flown is Mode.HOLD
    assert client.command(SET_MODE, 1, 99, 0) == TEMPORARILY_REJECTED
    assert client.texts()[-1] == "Unsupported main mode\t"
    assert client.command(SET_MODE, 1, 4, 77) == TEMPORARILY_REJECTED
    assert client.texts()[-1] == "Unsupported auto mode\t"


def test_the_old_message_changes_the_mode_too() -> None:
    client = Client("sih")
    client.send("SET_MODE", base_mode=1, custom_mode=Mode.LAND.custom_mode)
    assert client.last("COMMAND_ACK") | {"command": 176, "result": 0} == client.last("COMMAND_ACK")
    assert client.flown is Mode.LAND


@pytest.mark.parametrize("age", [0.9, 1.1])
def test_one_setpoint_younger_than_the_time_out_opens_offboard(age: float) -> None:
    client = Client("sih")
    client.rates()
    client.run(age)
    assert client.mode(Mode.OFFBOARD) == (ACCEPTED if age < 1.0 else TEMPORARILY_REJECTED)


def test_the_loss_is_noticed_at_a_look() -> None:
    took = []
    for phase in (0.0, 0.02, 0.04, 0.06, 0.08):
        client = in_offboard()
        client.bridge.autopilot.parameters.update(COM_OF_LOSS_T=0.2, COM_OBL_RC_ACT=5)
        client.run(phase)
        client.rates(thrust=0.49)
        took.append(client.run_until(lambda c=client: c.flown is Mode.HOLD, 1.0))  # type: ignore[misc]
    assert max(took) - min(took) == pytest.approx(0.08, abs=0.005)
    assert sum(took) / len(took) == pytest.approx(0.27, abs=0.02)


@pytest.mark.parametrize("hz", [50.0, 2.0, 1.05])
def test_a_slow_stream_holds_offboard_if_its_gaps_are_short_enough(hz: float) -> None:
    client = in_offboard()
    client.run(5.0, streaming(client, hz))
    assert client.flown is Mode.OFFBOARD
    assert "Failsafe activated\t" not in client.texts()


@pytest.mark.parametrize("timeout", [1.0, 0.5, 0.2])
@pytest.mark.parametrize(
    ("action", "mode"), [(0, Mode.RETURN), (1, Mode.RETURN), (3, Mode.RETURN), (4, Mode.LAND), (5, Mode.HOLD)]
)
def test_loss_of_the_stream(timeout: float, action: int, mode: Mode) -> None:
    """PX4 looks every 0.1 s and acts 0.02 s later. Seen: 0.04 to 0.17 s after the time-out, in CURRENT_MODE, which comes
    up to 0.05 s late."""
    client = in_offboard()
    client.bridge.autopilot.parameters.update(COM_OF_LOSS_T=timeout, COM_OBL_RC_ACT=action)
    client.rates(thrust=0.49)
    lost = client.run_until(lambda: client.flown is not Mode.OFFBOARD, 2.0)
    assert timeout + 0.015 < lost < timeout + 0.125
    assert client.flown is mode
    assert client.texts()[-1] == "Failsafe activated\t"
    client.command(512, 436)
    client.command(512, 0)
    values = client.last("CURRENT_MODE")
    assert (values["custom_mode"], values["intended_custom_mode"]) == (mode.custom_mode, Mode.OFFBOARD.custom_mode)
    assert client.last("HEARTBEAT")["system_status"] == 5


def test_until_the_loss_is_noticed_the_last_setpoint_is_flown() -> None:
    client = in_offboard(world=TURNING_AIR)
    client.rates(r=0.5, thrust=0.4905)
    client.run(1.0)
    assert client.flown is Mode.OFFBOARD
    assert client.bridge.truth.w_b[2] == pytest.approx(0.5, rel=0.1)


def test_a_stream_that_returns_takes_offboard_back_by_itself() -> None:
    client = in_offboard()
    client.bridge.autopilot.parameters["COM_OBL_RC_ACT"] = 5
    client.run(2.0)
    assert client.flown is Mode.HOLD
    each_step = streaming(client)
    start = client.bridge.now
    while client.flown is not Mode.OFFBOARD:
        client.run(client.bridge.step_s, each_step)
        assert client.bridge.now - start < 0.2
    assert 0.02 <= client.bridge.now - start <= 0.13


def test_a_stream_with_gaps_too_long_flips_in_and_out() -> None:
    client = in_offboard()
    client.bridge.autopilot.parameters["COM_OBL_RC_ACT"] = 5
    flown: list[Mode] = []

    def watch() -> None:
        if not flown or flown[-1] is not client.flown:
            flown.append(client.flown)

    for _ in range(3):
        client.rates(thrust=0.4905)
        client.run(1.25, watch)
    assert flown == [Mode.OFFBOARD, Mode.HOLD] * 3


def test_a_lost_stream_stays_lost_while_its_last_setpoint_is_old() -> None:
    client = in_offboard()
    client.bridge.autopilot.parameters["COM_OBL_RC_ACT"] = 5
    client.run(1.2)
    client.bridge.autopilot.parameters["COM_OF_LOSS_T"] = 1.05  # no new setpoint: the age alone decides
    client.run(0.5)
    assert client.flown is Mode.HOLD


def test_a_demand_of_an_earlier_offboard_is_not_flown_again() -> None:
    client = in_offboard()
    client.run(0.2, lambda: client.rates(r=1.0, thrust=0.4905))
    client.mode(Mode.HOLD)
    client.run(4.0, lambda: client.rates(r=1.0, thrust=0.4905))
    client.mode(Mode.OFFBOARD)
    client.run(0.5)
    assert client.flown is Mode.OFFBOARD
    assert client.bridge.truth.w_b[2] == pytest.approx(0.0, abs=0.02)


def test_an_ignored_yaw_rate_is_no_demand() -> None:
    client = in_offboard()
    client.run(1.0, lambda: client.rates(r=1.0, thrust=0.4905, mask=0x84))
    assert client.bridge.truth.w_b[2] == pytest.approx(0.0, abs=1e-3)


def test_rates_after_motors_begin_without_a_jump() -> None:
    client = Client("x500", direct=True, endpoints=1)
    hover = client.bridge.autopilot.cascade.hover
    client.motors(hover, hover, hover, hover)
    client.mode(Mode.OFFBOARD)
    client.run(0.1, lambda: client.motors(1.03 * hover, 0.97 * hover, 0.97 * hover, 1.03 * hover))
    rolling = client.bridge.truth.w_b[0]
    assert rolling < -0.3
    client.rates(p=rolling, thrust=hover)
    client.bridge.step()
    assert client.bridge.autopilot.commands == pytest.approx((hover,) * 4, abs=1e-6)


def test_the_operators_mode_is_not_undone_by_the_stream() -> None:
    client = in_offboard()
    assert client.mode(Mode.HOLD, endpoint=1) == ACCEPTED
    assert client.all("COMMAND_ACK", 1)
    assert len(client.all("COMMAND_ACK", 0)) == 1  # ours of before
    client.run(3.0, streaming(client))
    assert client.flown is Mode.HOLD
    client.run(2.0)
    assert client.flown is Mode.HOLD
    client.rates()
    assert client.mode(Mode.OFFBOARD) == ACCEPTED


def test_an_operators_mode_ends_a_failsafe_for_good() -> None:
    client = in_offboard()
    client.run(1.5)
    assert client.flown is Mode.RETURN
    assert client.mode(Mode.HOLD, endpoint=1) == ACCEPTED
    client.run(1.0, streaming(client))
    assert client.flown is Mode.HOLD


def test_after_an_automatic_landing_the_intent_is_offboard_again() -> None:
    client = in_offboard(start=Start.hover((0.0, 0.0, -1.0)))
    client.run_until(lambda: not client.bridge.autopilot.commander.armed, 20.0)
    assert client.texts()[-2:] == ["Landing detected\t", "Disarmed by landing\t"]
    client.run(1.0)
    heartbeat = client.last("HEARTBEAT")
    assert (heartbeat["custom_mode"], heartbeat["base_mode"], heartbeat["system_status"]) == (0x00060000, 0x01, 0)


@pytest.mark.parametrize(
    ("send", "base_mode"),
    [
        (lambda c: c.rates(), 0x81),
        (lambda c: c.rates(mask=0x07), 0x91),
        (lambda c: c.rates(mask=0x00), 0x91),
        (lambda c: c.rates(mask=0x84), 0x81),
    ],
)
def test_the_kind_of_setpoint_shows_in_the_base_mode(send: object, base_mode: int) -> None:
    client = in_offboard()
    send(client)  # type: ignore[operator]
    client.command(512, 0)
    assert client.last("HEARTBEAT")["base_mode"] == base_mode


@pytest.mark.parametrize("mask", [0x81, 0x82, 0xC0, 0x40])
def test_masks_px4_ignores_do_not_even_refresh_the_stream(mask: int) -> None:
    client = Client("sih")
    client.rates(mask=mask)
    assert client.mode(Mode.OFFBOARD) == TEMPORARILY_REJECTED


def test_setpoints_for_others_and_by_number_are_checked() -> None:
    client = Client("sih")
    client.send("SET_ATTITUDE_TARGET", type_mask=0x80, thrust=0.5, target_component=191)
    client.send("SET_ATTITUDE_TARGET", type_mask=0x80, thrust=0.5, target_system=2)
    client.send("SET_ATTITUDE_TARGET", type_mask=0x80, thrust=NAN)
    client.send("SET_ATTITUDE_TARGET", type_mask=0x80, thrust=math.inf)
    client.send("SET_ATTITUDE_TARGET", type_mask=0x07, thrust=0.5, q=(NAN, 0.0, 0.0, 0.0))
    client.send("SET_ATTITUDE_TARGET", type_mask=0x07, thrust=0.5, q=(0.0, 0.0, 0.0, 0.0))
    assert client.mode(Mode.OFFBOARD) == TEMPORARILY_REJECTED
    client.send("SET_ATTITUDE_TARGET", type_mask=0x80, thrust=0.5, target_system=0, target_component=0)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED


def test_a_rate_that_is_no_number_is_no_demand() -> None:
    client = in_offboard(world=TURNING_AIR)

    def each_step() -> None:
        client.rates(p=NAN, q=math.inf, r=0.4, thrust=0.49)

    client.run(1.5, each_step)
    truth = client.bridge.truth
    assert all(map(math.isfinite, (*truth.p_n, *truth.q_nb, *truth.w_b)))
    assert truth.w_b == pytest.approx((0.0, 0.0, 0.4), abs=0.05)


def test_absurd_setpoints_stay_finite() -> None:
    client = in_offboard()
    for value in (1e38, -1e38, 1e300):
        try:
            client.rates(p=value, q=-value, r=value, thrust=value)
        except OverflowError:
            continue  # does not fit the wire
        client.run(0.2)
    truth = client.bridge.truth
    assert all(map(math.isfinite, (*truth.p_n, *truth.v_n, *truth.q_nb, *truth.w_b)))


def test_thrust_body_counts_downwards() -> None:
    client = in_offboard()
    client.send("SET_ATTITUDE_TARGET", type_mask=0xA0, thrust=0.0, thrust_body=(0.0, 0.0, -0.6), q=(1, 0, 0, 0))
    client.run(0.8)
    assert client.bridge.truth.thrust == pytest.approx(0.6 * 20.0, rel=0.01)


@pytest.mark.parametrize("vehicle", ["x500", "sih"])
def test_rates_and_attitude_are_followed(vehicle: str) -> None:
    client = in_offboard(vehicle, world=TURNING_AIR)
    hover = client.bridge.autopilot.cascade.hover
    client.run(0.5, lambda: client.rates(p=0.5, thrust=hover))
    assert client.bridge.truth.w_b[0] == pytest.approx(0.5, rel=0.1)
    wanted = quaternion_from_euler(0.3, 0.2, -0.1)
    client.run(3.0, lambda: client.send("SET_ATTITUDE_TARGET", type_mask=0x07, thrust=hover, q=wanted))
    psi, theta, phi = euler_from_rotation(rotation_matrix(client.bridge.truth.q_nb))
    assert (psi, theta, phi) == pytest.approx((0.3, 0.2, -0.1), abs=0.02)


@pytest.mark.parametrize("direct", [False, True])
def test_motor_commands_count_only_where_motors_are_direct(direct: bool) -> None:
    client = Client("x500", direct=direct)
    client.motors(0.6, 0.6, 0.6, 0.6)
    assert client.mode(Mode.OFFBOARD) == (ACCEPTED if direct else TEMPORARILY_REJECTED)
    client.run(0.5, lambda: client.motors(0.7, 0.7, 0.7, 0.7))
    lifted = client.bridge.truth.thrust / (4 * 8.54858)
    assert lifted == pytest.approx(0.7 if direct else client.bridge.autopilot.cascade.hover, rel=1e-3)


def test_motor_commands_reach_each_rotor_and_negative_ones_the_paper() -> None:
    client = Client("paper")
    client.motors(0.02, 0.02, 0.02, 0.02)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    client.motors(0.03, -0.01, 0.02, 0.01)
    client.bridge.step()
    assert client.bridge.truth.rotor_thrusts == pytest.approx((7.5, -2.5, 5.0, 2.5))
    client.command(512, 375)
    assert client.last("ACTUATOR_OUTPUT_STATUS")["actuator"][:5] == pytest.approx((1030, 990, 1020, 1010, 900))
    client.motors(NAN, 0.0, 0.0, 0.0)
    client.motors(0.0, math.inf, 0.0, 0.0)
    client.send("SET_ACTUATOR_CONTROL_TARGET", controls=(0.5,) * 8, group_mlx=1)
    client.bridge.step()
    assert client.bridge.truth.rotor_thrusts == pytest.approx((7.5, -2.5, 5.0, 2.5))


def test_a_setpoint_before_the_step_after_the_mode_change_is_flown() -> None:
    client = Client("x500", direct=True)
    client.motors(0.0, 0.0, 0.0, 0.0)
    client.mode(Mode.OFFBOARD)
    client.motors(0.9, 0.9, 0.9, 0.9)
    client.run(0.2)
    assert client.bridge.truth.thrust == pytest.approx(0.9 * 4 * 8.54858, rel=1e-3)


def test_before_the_first_setpoint_in_offboard_the_vehicle_flies_on() -> None:
    for direct in (False, True):
        client = Client("x500", direct=direct, endpoints=1)
        client.motors(0.0, 0.0, 0.0, 0.0)
        client.rates(thrust=0.0)
        assert client.mode(Mode.OFFBOARD) == ACCEPTED
        client.run(0.5)
        assert client.bridge.truth.p_n == pytest.approx((0.0, 0.0, -10.0), abs=1e-3)


def test_commands_of_navigation_change_the_mode() -> None:
    client = Client("sih")
    client.ground_station()
    for command, mode in ((LAND, Mode.LAND), (RETURN, Mode.RETURN), (TAKEOFF, Mode.TAKEOFF)):
        assert client.command(command, *(NAN,) * 7) == ACCEPTED
        assert client.flown is mode
        client.run(0.1)
    assert "Landing at current position\t" in client.texts()
    assert "RTL: start return at 499 m (10 m above destination)\t" in client.texts()
