"""The automatic modes on every vehicle: hold, take off, land, return; and the same by hand in offboard."""

from __future__ import annotations

import math

import pytest

from companion.frames import quaternion_from_euler, rotation_matrix, tilt
from companion.mavlink.modes import Landed, Mode
from companion.world import Start, World
from tests.support.plant_client import ACCEPTED, ARM, LAND, NAN, RETURN, TAKEOFF, Client

VEHICLES = ("x500", "sih", "paper")
CHANGE_SPEED, REPOSITION = 178, 192
BREEZE = World(wind_n=(3.0, -2.0, 0.0))


def at_rest(client: Client, within: float = 0.02) -> None:
    """It hardly moves, for a second."""
    before = client.bridge.truth.p_n
    client.run(1.0)
    assert client.bridge.truth.p_n == pytest.approx(before, abs=within)


def ready(vehicle: str, world: World | None = None) -> Client:
    """Booted, on the ground, the operator listening."""
    client = Client(vehicle, world, landed=True)
    client.ground_station()
    client.run(4.6)
    return client


@pytest.mark.parametrize("vehicle", VEHICLES)
@pytest.mark.parametrize("world", [World(), BREEZE], ids=["still", "breeze"])
def test_take_off_hold_and_land(vehicle: str, world: World) -> None:
    client = ready(vehicle, world)
    states: list[tuple[Mode, Landed]] = []
    times: dict[tuple[Mode, Landed], float] = {}

    def watch() -> None:
        state = (client.flown, client.bridge.autopilot.landed_state)
        if not states or states[-1] != state:
            states.append(state)
            times[state] = client.bridge.truth.t_boot

    assert client.command(TAKEOFF, *(NAN,) * 7) == ACCEPTED
    assert client.flown is Mode.TAKEOFF  # at once, even disarmed
    client.run(0.3, watch)
    assert client.command(ARM, 1) == ACCEPTED
    armed = client.bridge.truth.t_boot
    client.run(16.0, watch)
    assert client.height == pytest.approx(2.5, abs=0.03)
    at_rest(client, 0.05 if world is BREEZE else 0.01)  # the integral is still taking up the breeze
    assert math.hypot(*client.bridge.truth.p_n[:2]) < (0.3 if world is BREEZE else 0.01)
    assert client.command(LAND, *(NAN,) * 7) == ACCEPTED
    landing = client.bridge.truth.t_boot
    client.run(13.0, watch)
    assert states == [
        (Mode.TAKEOFF, Landed.ON_GROUND),
        (Mode.TAKEOFF, Landed.TAKING_OFF),
        (Mode.HOLD, Landed.IN_AIR),
        (Mode.LAND, Landed.LANDING),
        (Mode.LAND, Landed.ON_GROUND),
        (Mode.HOLD, Landed.ON_GROUND),
    ]
    taking_off, holding = times[Mode.TAKEOFF, Landed.TAKING_OFF], times[Mode.HOLD, Landed.IN_AIR]
    landed, disarmed = times[Mode.LAND, Landed.ON_GROUND], times[Mode.HOLD, Landed.ON_GROUND]
    assert taking_off - armed == pytest.approx(1.85, rel=0.1)  # the times of px4.md and the recorded session
    assert holding - armed == pytest.approx(6.6, rel=0.15)
    assert landed - landing == pytest.approx(7.2, rel=0.1)
    assert disarmed - landed == pytest.approx(2.0, abs=0.03)
    assert not client.bridge.autopilot.commander.armed
    assert client.bridge.truth.thrust == pytest.approx(0.0, abs=1e-6)
    assert client.texts() == [
        "Armed by external command\t",
        "Using default takeoff altitude: 2.5 m\t",
        "Takeoff detected\t",
        "Landing at current position\t",
        "Landing detected\t",
        "Disarmed by landing\t",
    ]


def test_a_take_off_climbs_to_the_altitude_it_is_told() -> None:
    client = ready("x500")
    assert client.command(TAKEOFF, NAN, 0.0, 0.0, NAN, NAN, NAN, 489.4 + 8.0) == ACCEPTED
    client.command(ARM, 1)
    client.run(20.0)
    assert client.flown is Mode.HOLD
    assert client.height == pytest.approx(8.0, abs=0.03)


def test_a_take_off_goes_over_the_place_it_is_told_and_never_down() -> None:
    client = ready("x500")
    north, east = 12.0, -5.0
    there = client.bridge.autopilot.projection.reproject(north, east)
    assert client.command(TAKEOFF, NAN, 0.0, 0.0, NAN, *there, 489.4 + 8.0) == ACCEPTED
    client.command(ARM, 1)
    client.run(20.0)
    assert client.bridge.truth.p_n == pytest.approx((north, east, -8.0), abs=0.4)  # what a float tells of 47 deg
    assert client.command(TAKEOFF, *(NAN,) * 7) == ACCEPTED  # from here, as PX4 does
    client.run(0.1)
    assert client.command(TAKEOFF, NAN, 0.0, 0.0, NAN, NAN, NAN, 489.4 + 12.0) == ACCEPTED  # no: still higher
    client.run(14.0)
    assert client.height == pytest.approx(12.0, abs=0.03)
    assert client.command(TAKEOFF, NAN, 0.0, 0.0, NAN, NAN, NAN, 489.4 + 3.0) == ACCEPTED
    client.run(3.0)
    assert client.height == pytest.approx(12.0, abs=0.1)
    assert client.flown is Mode.HOLD
    assert client.texts()[-2:] == ["Using default takeoff altitude: 2.5 m\t", "Already higher than takeoff altitude\t"]


def test_a_speed_asked_for_in_hold_counts_until_the_mode_changes() -> None:
    client = Client("x500")
    place_of = client.bridge.autopilot.projection.reproject

    def cruise_to(north: float, speed: float) -> float:
        """m/s in the middle of the leg."""
        assert client.command(REPOSITION, speed, 1.0, 0.0, NAN, *place_of(north, 0.0), NAN) == ACCEPTED
        client.run(6.0)
        seen: list[float] = []
        client.run(1.0, lambda: seen.append(math.hypot(*client.bridge.truth.v_n[:2])))
        client.run(7.0)
        return sum(seen) / len(seen)

    assert client.command(CHANGE_SPEED, 1.0, 2.0, -1.0) == ACCEPTED
    assert cruise_to(20.0, -1.0) == pytest.approx(2.0, rel=0.05)
    assert cruise_to(-20.0, 4.0) == pytest.approx(4.0, rel=0.05)
    assert cruise_to(20.0, NAN) == pytest.approx(2.0, rel=0.05)
    client.mode(Mode.LAND)
    client.run(0.1)
    client.mode(Mode.HOLD)
    assert cruise_to(-30.0, -1.0) == pytest.approx(5.0, rel=0.05)


def test_hold_in_the_middle_of_a_take_off_stops_there() -> None:
    client = ready("x500")
    client.bridge.autopilot.parameters["MIS_TAKEOFF_ALT"] = 10.0
    client.command(TAKEOFF, *(NAN,) * 7)
    client.command(ARM, 1)
    client.run_until(lambda: client.height > 3.0, 15.0)
    client.mode(Mode.HOLD)
    client.run(6.0)
    assert client.height == pytest.approx(3.6, abs=0.6)
    at_rest(client)


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_hold_brakes_and_then_holds(vehicle: str) -> None:
    start = Start((0.0, 0.0, -20.0), (6.0, -4.0, 1.0), quaternion_from_euler(1.0, 0.2, -0.3), (0.5, -0.5, 0.2))
    client = Client(vehicle, start=start)
    client.run(15.0)
    assert math.hypot(*client.bridge.truth.p_n[:2]) < 25.0
    assert tilt(rotation_matrix(client.bridge.truth.q_nb)) < 0.02
    at_rest(client)


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_hold_takes_up_a_wind_it_does_not_know(vehicle: str) -> None:
    client = Client(vehicle, BREEZE)
    client.rates(thrust=client.bridge.autopilot.cascade.hover)
    client.mode(Mode.OFFBOARD)
    client.bridge.step()
    client.mode(Mode.HOLD)  # the integrals begin at nothing
    client.run(25.0)
    at_rest(client)
    assert client.bridge.truth.p_n == pytest.approx((0.0, 0.0, -10.0), abs=0.2)


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_hold_after_the_rotors_were_flown_directly(vehicle: str) -> None:
    client = Client(vehicle, direct=True)
    hover = client.bridge.autopilot.cascade.commands
    client.motors(*hover)
    client.mode(Mode.OFFBOARD)
    client.run(0.6, lambda: client.motors(*(1.05 * c for c in hover[:2]), *hover[2:]))
    assert client.mode(Mode.HOLD) == ACCEPTED
    client.run(8.0)
    at_rest(client)
    assert client.height == pytest.approx(10.0, abs=3.0)


@pytest.mark.parametrize(
    ("start", "near", "highest"),
    [
        ((6.0, -4.0, -5.0), 10.0, 14.4),  # within the acceptance radius: twice the distance
        ((0.0, 9.0, -30.0), 10.0, 30.0),  # already higher
        ((25.0, 0.0, -3.0), 10.0, 30.0),  # far
        ((25.0, 0.0, -3.0), 40.0, 25.0),  # within the cone
    ],
)
def test_return_climbs_as_px4_does_and_lands_at_home(
    start: tuple[float, float, float], near: float, highest: float
) -> None:
    client = Client("sih", start=Start.hover(start), endpoints=1)
    client.bridge.autopilot.parameters["RTL_MIN_DIST"] = near
    client.bridge.autopilot.parameters["COM_DISARM_LAND"] = 0.5
    assert client.command(RETURN, *(NAN,) * 7) == ACCEPTED
    top = 0.0

    def watch() -> None:
        nonlocal top
        top = max(top, client.height)

    while client.bridge.autopilot.commander.armed:
        client.run(0.5, watch)
        assert client.bridge.now < 120.0
    assert top == pytest.approx(highest, abs=0.9)
    assert client.bridge.truth.p_n == pytest.approx((0.0, 0.0, 0.0), abs=0.3)


def test_taking_off_and_landing_by_hand_in_offboard() -> None:
    """px4.md section 3, recipe B."""
    client = ready("sih")
    hover = client.bridge.autopilot.cascade.hover
    client.run(0.6, lambda: client.rates(thrust=0.05))
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    assert client.command(ARM, 1) == ACCEPTED
    client.run(1.0, lambda: client.rates(thrust=0.05))
    assert client.bridge.truth.thrust == pytest.approx(1.0, rel=0.01)
    assert client.bridge.autopilot.landed_state is Landed.ON_GROUND
    client.run(1.0, lambda: client.rates(thrust=1.3 * hover))
    assert client.bridge.autopilot.landed_state is Landed.IN_AIR
    assert client.height > 0.5
    client.run(4.0, lambda: client.rates(thrust=0.9 * hover))
    assert client.bridge.truth.on_ground
    client.run(4.0, lambda: client.rates(thrust=0.05))
    assert client.texts()[-2:] == ["Landing detected\t", "Disarmed by landing\t"]
