"""Sticks, and what the vehicle does when it loses something: as PX4 decides it."""

from __future__ import annotations

import math

import pytest

from companion.mavlink.modes import Mode
from tests.sim_bridge.test_offboard import in_offboard, streaming
from tests.support.plant_client import ACCEPTED, ARM, LAND, TEMPORARILY_REJECTED, Client


def with_a_pilot(**options: object) -> Client:
    """In a hover, armed by somebody who holds the sticks."""
    client = Client("sih", landed=True, **options)
    client.ground_station()
    client.piloted(4.6)
    assert client.mode(Mode.POSITION) == ACCEPTED
    assert client.command(ARM, 1) == ACCEPTED
    client.piloted(6.0, throttle=1.0)
    client.piloted(1.5)
    return client


def test_a_pilot_takes_off_flies_and_lands_in_position_mode() -> None:
    client = with_a_pilot()
    height = client.height
    assert height > 3.0
    client.piloted(2.0)
    assert client.height == pytest.approx(height, abs=0.4)
    client.piloted(2.0, pitch=0.5)
    north, east, _ = client.bridge.truth.v_n
    assert north > 1.0
    assert east == pytest.approx(0.0, abs=0.1)
    client.piloted(4.0)
    assert math.hypot(*client.bridge.truth.v_n) < 0.15
    client.piloted(1.0, yaw=0.5)
    assert client.bridge.truth.w_b[2] > 0.5
    client.piloted(0.5)
    client.piloted(12.0, throttle=-1.0)
    assert client.texts()[-2:] == ["Landing detected\t", "Disarmed by landing\t"]


def test_sticks_take_off_by_px4s_ramp_and_climb_slowly_near_the_ground() -> None:
    client = Client("sih", landed=True)
    client.ground_station()
    client.piloted(4.6)
    client.mode(Mode.POSITION)
    assert client.command(ARM, 1) == ACCEPTED
    client.piloted(1.5, throttle=0.25)  # not enough for PX4 to take off
    assert client.bridge.truth.on_ground
    client.piloted(1.0, throttle=1.0)  # the throttle opens by and by
    assert client.bridge.truth.on_ground
    while client.height < 5.0:
        client.piloted(0.04, throttle=1.0)
    assert client.bridge.truth.v_n[2] == pytest.approx(-1.5, abs=0.15)  # MPC_TKO_SPEED, up to MPC_LAND_ALT2
    while client.height < 18.0:
        client.piloted(0.04, throttle=1.0)
    assert client.bridge.truth.v_n[2] == pytest.approx(-3.0, abs=0.2)  # MPC_Z_VEL_MAX_UP, from MPC_LAND_ALT1
    client.piloted(3.0)
    while client.height > 10.5:
        client.piloted(0.04, throttle=-1.0)
    assert client.bridge.truth.v_n[2] == pytest.approx(1.5, abs=0.15)  # MPC_Z_VEL_MAX_DN
    while client.height > 3.0:
        client.piloted(0.04, throttle=-1.0)
    assert client.bridge.truth.v_n[2] == pytest.approx(0.7, abs=0.15)  # MPC_LAND_SPEED


def test_a_throttle_that_is_open_prevents_arming_by_stick() -> None:
    client = Client("sih", landed=True)
    client.ground_station()
    client.piloted(4.6, throttle=0.6)
    client.mode(Mode.POSITION)
    assert client.command(ARM, 1) == TEMPORARILY_REJECTED
    assert client.texts()[-1] == "Arming denied: throttle not in safe position\t"


@pytest.mark.parametrize("mode", [Mode.ALTITUDE, Mode.STABILIZED, Mode.ACRO])
def test_the_other_manual_modes_answer_the_sticks(mode: Mode) -> None:
    client = with_a_pilot()
    assert client.mode(mode) == ACCEPTED
    if mode is Mode.ACRO:
        client.piloted(0.2, roll=0.2, throttle=0.0)
        assert client.bridge.truth.w_b[0] == pytest.approx(0.2 * math.radians(100.0), rel=0.4)
        return
    height = client.height
    client.piloted(1.0, roll=0.5)
    w, x, y, z = client.bridge.truth.q_nb
    assert 2.0 * (w * x + y * z) > 0.1  # leans right
    if mode is Mode.ALTITUDE:
        assert client.height == pytest.approx(height, abs=0.5)
    heartbeat = client.command(512, 0), client.last("HEARTBEAT")["base_mode"]
    assert heartbeat[1] == 0xD1


def test_sticks_moved_with_intent_take_over_from_offboard() -> None:
    client = in_offboard()
    client.piloted(1.0, streaming(client))
    assert client.flown is Mode.OFFBOARD
    client.sticks(roll=0.6)  # a single jump is no intent
    client.run(0.04, streaming(client))
    client.piloted(0.5, streaming(client), roll=0.6)
    assert client.flown is Mode.OFFBOARD
    for deflection in (0.5, 0.4, 0.3, 0.2, 0.1, 0.0):
        client.piloted(0.04, streaming(client), roll=deflection)
    assert client.flown is Mode.POSITION
    assert client.texts()[-1] == "Pilot took over using sticks\t"
    client.piloted(2.0, streaming(client))
    assert client.flown is Mode.POSITION  # the stream goes on and does not count


def test_sticks_lost_in_offboard_hold_and_then_return_although_the_stream_goes_on() -> None:
    client = with_a_pilot()
    stream = streaming(client)
    client.piloted(0.2, stream)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    lost = client.bridge.now
    while client.flown is Mode.OFFBOARD:
        client.run(0.02, stream)
    assert client.bridge.now - lost == pytest.approx(1.065, abs=0.05)  # measured on PX4
    assert client.flown is Mode.HOLD
    assert client.texts()[-1] == "Failsafe activated: entering Hold for 5 seconds\t"
    while client.flown is Mode.HOLD:
        client.run(0.02, stream)
    assert client.bridge.now - lost == pytest.approx(6.05, abs=0.1)
    assert client.flown is Mode.RETURN


@pytest.mark.parametrize(
    ("action", "mode"),
    [(0, Mode.POSITION), (1, Mode.ALTITUDE), (2, Mode.STABILIZED), (3, Mode.RETURN), (4, Mode.LAND), (5, Mode.HOLD)],
)
def test_loss_of_the_stream_with_a_pilot(action: int, mode: Mode) -> None:
    client = in_offboard()
    client.bridge.autopilot.parameters.update(COM_OBL_RC_ACT=action)
    client.piloted(0.4, streaming(client))
    client.rates(thrust=0.49)
    client.piloted(1.2)
    assert client.flown is mode
    assert "Failsafe activated\t" in client.texts()


def test_loss_of_the_stream_can_disarm() -> None:
    client = in_offboard()
    client.bridge.autopilot.parameters.update(COM_OBL_RC_ACT=7)
    client.run(1.3)
    assert not client.bridge.autopilot.commander.armed
    assert client.texts()[-1] == "Disarmed by failsafe\t"


@pytest.mark.parametrize(
    ("action", "critical", "emergency"),
    [(0, None, None), (1, Mode.RETURN, Mode.RETURN), (2, Mode.LAND, Mode.LAND), (3, Mode.RETURN, Mode.LAND)],
)
def test_a_battery_that_runs_low(action: int, critical: Mode | None, emergency: Mode | None) -> None:
    client = in_offboard()
    parameters = client.bridge.autopilot.parameters
    parameters.update(COM_LOW_BAT_ACT=action, SIM_BAT_DRAIN=1.0, SIM_BAT_MIN_PCT=10.0)
    stream = streaming(client)
    client.run(1.2, stream)
    assert client.flown is Mode.OFFBOARD
    assert client.texts()[-1] == "Low battery\t"
    parameters["SIM_BAT_MIN_PCT"] = 6.0
    client.run(0.2, stream)
    assert client.flown is (Mode.OFFBOARD if critical is None else Mode.HOLD)  # warned first, if it acts at all
    if critical is None:
        return
    client.run(5.0, stream)
    assert client.flown is critical
    parameters["SIM_BAT_MIN_PCT"] = 3.0
    client.run(0.3, stream)
    assert client.flown is emergency


def test_a_silent_ground_station() -> None:
    client = Client("sih")
    client.ground_station()
    client.bridge.autopilot.parameters.update(NAV_DLL_ACT=2, COM_DL_LOSS_T=3)
    client._heartbeat_at = None
    client.run(3.3)
    assert client.flown is Mode.HOLD
    client.run(4.9)
    assert client.flown is Mode.RETURN
    client.ground_station()
    client.run(0.5)
    assert client.flown is Mode.RETURN  # until somebody changes the mode
    assert client.mode(Mode.HOLD) == ACCEPTED
    client.run(0.1)
    assert client.flown is Mode.HOLD
    assert "GCS connection regained\t" in client.texts()


def test_an_operator_who_interrupts_a_failsafe_is_obeyed_until_it_gets_worse() -> None:
    client = in_offboard()
    parameters = client.bridge.autopilot.parameters
    parameters.update(COM_LOW_BAT_ACT=3, SIM_BAT_DRAIN=1.0, SIM_BAT_MIN_PCT=6.0)
    client.run(1.2, streaming(client))
    client.run(5.0, streaming(client))
    assert client.flown is Mode.RETURN
    assert client.mode(Mode.HOLD) == ACCEPTED
    client.run(0.5)
    assert client.flown is Mode.HOLD
    assert client.bridge.autopilot.commander.failsafe is None
    parameters["SIM_BAT_MIN_PCT"] = 3.0
    client.run(0.1)
    assert client.bridge.autopilot.commander.failsafe is not None
    client.run(5.1)
    assert client.flown is Mode.LAND


def test_termination_cuts_the_motors_and_is_final() -> None:
    client = Client("sih")
    assert client.command(185, 1.0) == ACCEPTED
    client.run(0.3)
    assert client.bridge.truth.thrust < 0.1
    assert client.command(512, 0) == ACCEPTED
    assert client.last("HEARTBEAT")["system_status"] == 8
    assert client.mode(Mode.HOLD) == TEMPORARILY_REJECTED


def test_a_vehicle_that_tips_over_is_only_warned_of_while_the_breaker_is_in() -> None:
    client = in_offboard()
    lying = (math.cos(0.6), math.sin(0.6), 0.0, 0.0)

    def lean() -> None:
        client.send("SET_ATTITUDE_TARGET", q=lying, thrust=0.6, type_mask=0x07)

    client.run(0.8, lean)
    assert client.flown is Mode.OFFBOARD
    client.bridge.autopilot.parameters["CBRK_FLIGHTTERM"] = 0
    client.run(0.5, lean)
    assert client.flown is Mode.TERMINATION


def test_landing_is_not_interrupted_by_a_return() -> None:
    client = Client("sih")
    client.command(LAND)
    client.bridge.autopilot.parameters.update(COM_LOW_BAT_ACT=1, SIM_BAT_DRAIN=1.0, SIM_BAT_MIN_PCT=6.0)
    client.run(1.5)
    assert client.flown is Mode.LAND
    assert client.bridge.autopilot.commander.failsafe is None
