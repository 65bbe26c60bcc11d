"""Offboard setpoints of places, velocities and accelerations, as PX4 reads and flies them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.frames import quaternion_from_euler
from companion.mavlink.modes import Mode
from companion.world import Start
from tests.support.plant_client import ACCEPTED, ARM, NAN, TEMPORARILY_REJECTED, Client

POSITION_ONLY, VELOCITY_ONLY, ACCELERATION_ONLY = 0b110111111000, 0b110111000111, 0b110000111111
WITH_HEADING, WITH_HEADING_RATE = ~(1 << 10), ~(1 << 11)
LOCAL_NED, BODY_NED = 1, 8


def target(client: Client, mask: int, frame: int = LOCAL_NED, **fields: float) -> None:
    client.send("SET_POSITION_TARGET_LOCAL_NED", coordinate_frame=frame, type_mask=mask & 0xFFFF, **fields)


def flying(seconds: float, mask: int, frame: int = LOCAL_NED, client: Client | None = None, **fields: float) -> Client:
    """Fly a setpoint, sent twenty times a second, from a hover."""
    client = client or Client("sih")
    target(client, mask, frame, **fields)
    if client.flown is not Mode.OFFBOARD:
        assert client.mode(Mode.OFFBOARD) == ACCEPTED
    for _ in range(round(20 * seconds)):
        target(client, mask, frame, **fields)
        client.run(0.05)
    assert client.flown is Mode.OFFBOARD
    return client


def test_a_place_is_flown_to_as_px4_does_it() -> None:
    client = flying(2.0, POSITION_ONLY, x=5.0, y=0.0, z=-10.0)
    assert 1.5 < client.bridge.truth.p_n[0] < 4.5
    flying(10.0, POSITION_ONLY, client=client, x=5.0, y=0.0, z=-12.0)
    assert client.bridge.truth.p_n == pytest.approx((5.0, 0.0, -12.0), abs=0.3)
    values = client.last("POSITION_TARGET_LOCAL_NED")
    assert (values["x"], values["z"], values["coordinate_frame"]) == (5.0, -12.0, 1)
    client.command(512, 0)
    assert client.last("HEARTBEAT")["base_mode"] == 0x91


def test_velocity_acceleration_and_mixtures() -> None:
    client = flying(3.0, VELOCITY_ONLY, vx=2.0, vy=0.0, vz=0.0)
    assert client.bridge.truth.v_n[0] == pytest.approx(1.6, abs=0.35)  # as the vehicle of PX4's own simulation
    client = flying(1.0, ACCELERATION_ONLY, afx=0.0, afy=1.0, afz=0.0)
    assert client.bridge.truth.v_n[1] == pytest.approx(1.0 - math.exp(-1.0), abs=0.25)  # the air at 1 / s
    height_and_velocity = 0b110111100011 & ~(1 << 2)
    client = flying(5.0, height_and_velocity, vx=0.0, vy=1.0, z=-13.0)
    assert client.height == pytest.approx(13.0, abs=0.5)
    assert client.bridge.truth.v_n[1] == pytest.approx(0.95, abs=0.2)


def test_the_bodys_frame_turns_with_the_heading() -> None:
    east = Start.hover((0.0, 0.0, -10.0), math.radians(90.0))
    client = flying(2.0, VELOCITY_ONLY, BODY_NED, Client("sih", start=east), vx=1.0, vy=0.0, vz=0.0)
    north, y, _ = client.bridge.truth.v_n
    assert y > 0.5
    assert north == pytest.approx(0.0, abs=0.1)


def test_heading_and_its_rate() -> None:
    client = flying(4.0, POSITION_ONLY & WITH_HEADING, x=0.0, y=0.0, z=-10.0, yaw=1.0)
    q = client.bridge.truth.q_nb
    assert abs(sum(a * b for a, b in zip(q, quaternion_from_euler(1.0, 0.0, 0.0), strict=True))) > 0.999
    client = flying(2.0, VELOCITY_ONLY & WITH_HEADING_RATE, vx=0.0, vy=0.0, vz=0.0, yaw_rate=0.5)
    assert client.bridge.truth.w_b[2] == pytest.approx(0.5, abs=0.1)


def test_what_asks_for_nothing_is_told_of_and_does_not_count() -> None:
    client = Client("sih")
    client.ground_station()
    target(client, 0xFFFF)
    target(client, POSITION_ONLY, frame=7)
    target(client, ACCELERATION_ONLY | 1 << 9, afz=-1.0)
    target(client, POSITION_ONLY, x=NAN, y=NAN, z=NAN)
    assert client.texts() == [
        "SET_POSITION_TARGET_LOCAL_NED invalid\t",
        "SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 unsupported\t",
        "SET_POSITION_TARGET_LOCAL_NED force not supported\t",
        "SET_POSITION_TARGET_LOCAL_NED invalid\t",
    ]
    target(client, POSITION_ONLY, target_system=2, z=-10.0)
    target(client, POSITION_ONLY, target_component=191, z=-10.0)
    assert client.mode(Mode.OFFBOARD) == TEMPORARILY_REJECTED


@pytest.mark.parametrize(("mask", "fields"), [(0b110111111110, {"x": 50.0}), (VELOCITY_ONLY, {"vx": NAN})])
def test_half_a_setpoint_stops_the_vehicle(mask: int, fields: dict[str, float]) -> None:
    client = flying(2.0, VELOCITY_ONLY, vx=3.0, vy=0.0, vz=0.0)
    flying(5.0, mask, client=client, **({"vy": 0.0, "vz": 0.0} | fields))
    assert math.hypot(*client.bridge.truth.v_n) < 0.3


def test_global_targets() -> None:
    client = Client("sih")
    client.ground_station()
    place: dict[str, Any] = {"lat_int": 473977420 + 449, "lon_int": 85455940, "alt": 12.0}
    for frame in (6, 5):
        values = place | {"alt": 12.0 if frame == 6 else 501.4}
        for _ in range(240):
            client.send("SET_POSITION_TARGET_GLOBAL_INT", coordinate_frame=frame, type_mask=POSITION_ONLY, **values)
            if client.flown is not Mode.OFFBOARD:
                assert client.mode(Mode.OFFBOARD) == ACCEPTED
            client.run(0.05)
        assert client.bridge.truth.p_n == pytest.approx((5.0, 0.0, -12.0), abs=0.3)
    client.send("SET_POSITION_TARGET_GLOBAL_INT", coordinate_frame=1, type_mask=POSITION_ONLY, **place)
    assert client.texts()[-1] == "SET_POSITION_TARGET_GLOBAL_INT invalid coordinate frame 1\t"


def test_from_the_ground_to_the_ground() -> None:
    client = Client("sih", landed=True)
    client.ground_station()
    client.run(5.0)
    target(client, POSITION_ONLY, z=-3.0)
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    assert client.command(ARM, 1) == ACCEPTED
    flying(9.0, POSITION_ONLY, client=client, z=-3.0)
    assert client.height == pytest.approx(3.0, abs=0.3)
    assert "Takeoff detected\t" in client.texts()
    commander = client.bridge.autopilot.commander
    for _ in range(400):
        target(client, VELOCITY_ONLY, vz=0.7)
        client.run(0.05)
        if not commander.armed:
            break
    assert client.texts()[-2:] == ["Landing detected\t", "Disarmed by landing\t"]


@pytest.mark.parametrize("mask", [0x80, 0x07])
def test_numbers_that_are_none_do_not_hurt(mask: int) -> None:
    client = Client("sih")
    client.rates(thrust=0.4905)
    client.mode(Mode.OFFBOARD)
    for _ in range(20):
        client.rates(thrust=0.4905)
        client.send("SET_ATTITUDE_TARGET", type_mask=mask, thrust=NAN, q=(NAN,) * 4, body_roll_rate=NAN)
        client.send("SET_ATTITUDE_TARGET", type_mask=mask, thrust=math.inf, q=(0.0,) * 4, body_pitch_rate=-math.inf)
        client.run(0.05)
    assert client.flown is Mode.OFFBOARD
    assert all(map(math.isfinite, client.bridge.truth.p_n))
    assert client.height == pytest.approx(10.0, abs=1.0)
