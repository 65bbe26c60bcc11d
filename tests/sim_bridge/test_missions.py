"""Missions, geofences, rally points: the protocol as PX4 speaks it, and what is flown of it."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.mavlink.modes import Landed, Mode
from tests.support.plant_client import ACCEPTED, ARM, DENIED, NAN, TEMPORARILY_REJECTED, Client

FAILED = 4
MISSION, FENCE, RALLY = 0, 1, 2
HOME = (47.397742, 8.545594)
METRE = 1.0 / math.radians(1.0) / 6371000.0  # degrees of latitude
START, SET_CURRENT = 300, 224


def item(command: int, north: float = 0.0, east: float = 0.0, up: float = 0.0, **fields: Any) -> dict[str, Any]:
    """A MISSION_ITEM_INT at so many m from home, ``up`` above it."""
    place = {
        "frame": 6,
        "x": round((HOME[0] + north * METRE) * 1e7),
        "y": round((HOME[1] + east * METRE / math.cos(math.radians(HOME[0]))) * 1e7),
        "z": up,
    }
    return {"command": command, "autocontinue": 1} | place | fields


def order(command: int, *params: float) -> dict[str, Any]:
    """An item without a place."""
    named = {f"param{i + 1}": value for i, value in enumerate(params)}
    return {"command": command, "autocontinue": 1, "frame": 2} | named


def upload(client: Client, items: list[dict[str, Any]], kind: int = MISSION, endpoint: int = 0) -> dict[str, Any]:
    """Send a list as it is asked for; the last MISSION_ACK."""
    client.send("MISSION_COUNT", endpoint, count=len(items), mission_type=kind)
    for _ in items:
        asked = [h for h in client.heard if h.endpoint == endpoint and h.name == "MISSION_REQUEST_INT"]
        if client.all("MISSION_ACK", endpoint) and client.heard[-1].name == "MISSION_ACK":
            break
        seq = asked[-1].fields["seq"]
        client.send("MISSION_ITEM_INT", endpoint, seq=seq, mission_type=kind, **items[seq])
    return client.last("MISSION_ACK", endpoint)


def download(client: Client, kind: int = MISSION) -> list[dict[str, Any]]:
    client.send("MISSION_REQUEST_LIST", mission_type=kind)
    count = client.last("MISSION_COUNT")["count"]
    items = []
    for seq in range(count):
        client.send("MISSION_REQUEST_INT", seq=seq, mission_type=kind)
        items.append(client.last("MISSION_ITEM_INT"))
    client.send("MISSION_ACK", type=0, mission_type=kind)
    return items


SQUARE = [
    item(22, up=10.0),
    item(16, 30.0, 0.0, 10.0, param4=NAN),
    item(16, 30.0, 30.0, 12.0, param4=NAN),
    item(16, 0.0, 30.0, 10.0, param4=NAN),
]


def on_the_ground() -> Client:
    client = Client("sih", landed=True)
    client.ground_station()
    client.run(5.0)
    return client


def flown(client: Client, at_most: float) -> list[tuple[Mode, int]]:
    """Fly until the mission is over: which item was current in which mode."""
    seen: list[tuple[Mode, int]] = []

    def watch() -> bool:
        now = (client.flown, client.bridge.autopilot.missions.current)
        if not seen or seen[-1] != now:
            seen.append(now)
        return client.flown is not Mode.MISSION or not client.bridge.autopilot.commander.armed

    client.run_until(watch, at_most)
    return seen


def test_what_goes_up_comes_down_again() -> None:
    client = Client("sih")
    sent = [*SQUARE, item(19, 5.0, 5.0, 9.0, param1=3.0, param4=0.0), order(178, 1.0, 2.5), order(20)]
    sent[1] = item(16, 30.0, 0.0, 10.0, param1=1.5, param2=2.0, param4=-90.0)
    assert upload(client, sent)["type"] == 0
    identity = client.last("MISSION_ACK")["opaque_id"]
    assert identity != 0
    got = download(client)
    assert client.last("MISSION_COUNT")["opaque_id"] == identity
    assert [i["command"] for i in got] == [22, 16, 16, 16, 19, 178, 20]
    for before, after in zip(sent, got, strict=True):
        assert (after["frame"], after["x"], after["y"]) == (before["frame"], before.get("x", 0), before.get("y", 0))
    assert (got[1]["param1"], got[1]["param2"], got[1]["param4"]) == (1.5, 2.0, 270.0)
    assert [i["current"] for i in got] == [1, 0, 0, 0, 0, 0, 0]
    client.run(1.1)
    values = client.last("MISSION_CURRENT")
    assert (values["seq"], values["total"], values["mission_state"], values["mission_id"]) == (0, 7, 2, identity)


def test_the_three_lists_are_apart_and_cleared_apart() -> None:
    client = Client("sih")
    fence = [item(5001, n, e, param1=4.0) for n, e in ((-50, -50), (50, -50), (50, 50), (-50, 50))]
    fence.append(item(5003, param1=80.0))
    assert upload(client, SQUARE)["type"] == 0
    assert upload(client, fence, FENCE)["type"] == 0
    assert upload(client, [item(5100, 3.0, 3.0, 5.0)], RALLY)["type"] == 0
    assert [len(download(client, kind)) for kind in (MISSION, FENCE, RALLY)] == [4, 5, 1]
    assert [i["param1"] for i in download(client, FENCE)] == [4.0, 4.0, 4.0, 4.0, 80.0]
    client.send("MISSION_CLEAR_ALL", mission_type=FENCE)
    assert client.last("MISSION_ACK") | {"type": 0, "mission_type": FENCE} == client.last("MISSION_ACK")
    assert [len(download(client, kind)) for kind in (MISSION, FENCE, RALLY)] == [4, 0, 1]
    client.send("MISSION_CLEAR_ALL", mission_type=255)
    assert [len(download(client, kind)) for kind in (MISSION, FENCE, RALLY)] == [0, 0, 0]
    client.run(1.1)
    assert client.last("MISSION_CURRENT")["total"] == 65535


@pytest.mark.parametrize(
    ("wrong", "answer"),
    [
        (item(31000), 3),
        (item(16, frame=10), 2),
        (item(16, param3=5.0), 8),
        (order(178, 1.0, 2.0, 0.0, 7.0), 9),
        (item(5001, param1=4.0), 1),
        (item(21, frame=3, param3=1.0), 8),
    ],
)
def test_an_item_that_is_wrong_ends_the_upload(wrong: dict[str, Any], answer: int) -> None:
    client = Client("sih")
    assert upload(client, SQUARE)["type"] == 0
    assert upload(client, [SQUARE[0], wrong, SQUARE[1]])["type"] == answer
    assert len(download(client)) == 4  # the list before is still there
    assert upload(client, SQUARE[:2])["type"] == 0


def test_an_upload_that_stops_is_asked_for_again_and_then_given_up() -> None:
    client = Client("sih")
    client.ground_station()
    client.send("MISSION_COUNT", 1, count=3)
    client.send("MISSION_ITEM_INT", 1, seq=0, **SQUARE[0])
    asked = len(client.all("MISSION_REQUEST_INT", 1))
    client.run(4.9)
    assert len(client.all("MISSION_REQUEST_INT", 1)) - asked == pytest.approx(19, abs=2)  # every 0.25 s
    assert client.last("MISSION_REQUEST_INT", 1)["seq"] == 1
    assert upload(client, SQUARE[:2], endpoint=0)["type"] == 1  # somebody else's upload is under way
    client.run(0.3)
    assert client.texts()[-1] == "Mission sync timeout\t"
    assert upload(client, SQUARE[:2])["type"] == 0


def test_too_much_and_too_odd() -> None:
    client = Client("sih")
    client.ground_station()
    client.send("MISSION_COUNT", count=501)
    assert client.last("MISSION_ACK")["type"] == 4
    client.send("MISSION_COUNT", count=2, mission_type=7)
    assert client.last("MISSION_ACK")["type"] == 4
    client.send("MISSION_ITEM_INT", 1, seq=3, **SQUARE[0])
    assert client.texts()[-1] == "REJ. MIS ITEM: partner id mismatch\t"
    client.send("MISSION_REQUEST_LIST", 1)
    client.send("MISSION_COUNT", 1, count=1)
    assert client.texts()[-1] == "WPM: IGN MISSION_COUNT: Busy\t"
    assert client.last("MISSION_ACK", 1)["type"] == 1
    before = len(client.heard)
    client.send("MISSION_REQUEST_LIST", target_system=2)
    client.send("MISSION_COUNT", target_component=55, count=1)
    assert len(client.heard) == before


def test_the_old_float_items_are_taken_too() -> None:
    client = Client("sih")
    client.send("MISSION_COUNT", count=1)
    client.send("MISSION_ITEM", seq=0, command=16, frame=3, x=HOME[0], y=HOME[1], z=7.0, autocontinue=1, param4=NAN)
    assert client.last("MISSION_ACK")["type"] == 0
    client.send("MISSION_REQUEST_LIST")
    client.send("MISSION_REQUEST", seq=0)
    got = client.last("MISSION_ITEM")
    assert (got["frame"], got["z"]) == (3, 7.0)
    assert got["x"] == pytest.approx(HOME[0], abs=1e-5)


def test_a_mission_is_flown_and_ends_in_hold() -> None:
    client = on_the_ground()
    assert client.mode(Mode.MISSION) == ACCEPTED
    assert client.command(ARM, 1) == TEMPORARILY_REJECTED  # there is none yet
    assert upload(client, SQUARE)["type"] == 0
    client.run(0.1)
    assert client.command(ARM, 1) == ACCEPTED
    landed: list[Landed] = []
    seen: list[int] = []
    start = client.bridge.now
    while client.flown is Mode.MISSION and client.bridge.now - start < 90.0:
        client.step()
        state, current = client.bridge.autopilot.landed_state, client.bridge.autopilot.missions.current
        landed += [state] if landed[-1:] != [state] else []
        seen += [current] if seen[-1:] != [current] else []
    assert landed == [Landed.ON_GROUND, Landed.TAKING_OFF, Landed.IN_AIR]
    assert seen == [0, 1, 2, 3]
    assert client.flown is Mode.HOLD
    assert client.all("MISSION_ITEM_REACHED")[0]["seq"] == 0
    client.run(0.02)  # it is told at the link's next look
    assert client.last("MISSION_CURRENT")["mission_state"] == 5
    client.run(9.0)
    north, east, down = client.bridge.truth.p_n
    assert (north, east, -down) == pytest.approx((0.0, 30.0, 10.0), abs=0.8)
    assert client.last("MISSION_ITEM_REACHED")["seq"] == 3


def test_orders_on_the_way() -> None:
    client = Client("sih")
    client.ground_station()
    plan = [
        order(178, 1.0, 2.0, -1.0),
        item(16, 20.0, 0.0, 10.0, param2=0.5, param4=90.0),
        order(93, 2.0),
        item(19, 20.0, 0.0, 10.0, param1=2.0),
        order(177, 1.0, 1.0),
        item(195, 100.0, 0.0, 0.0),
        item(16, 20.0, 20.0, 10.0, param2=0.5, param4=NAN),
        order(20),
    ]
    assert upload(client, plan)["type"] == 0
    client.run(0.1)
    assert client.mode(Mode.MISSION) == ACCEPTED
    fastest = 0.0
    visited: list[int] = []
    start = client.bridge.now
    while client.flown is Mode.MISSION and client.bridge.now - start < 90.0:
        client.step()
        fastest = max(fastest, math.hypot(*client.bridge.truth.v_n[:2]))
        current = client.bridge.autopilot.missions.current
        if not visited or visited[-1] != current:
            visited.append(current)
    assert [i for i in visited if i in (1, 2, 3, 6)] == [1, 2, 3, 2, 3, 6]  # 1 is reached as soon as it is jumped to
    assert fastest < 2.3
    assert client.flown is Mode.RETURN
    north, east, _ = client.bridge.truth.p_n
    assert (north, east) == pytest.approx((20.0, 20.0), abs=1.0)
    x, y = client.bridge.truth.q_nb[0], client.bridge.truth.q_nb[3]
    bearing = math.atan2(-20.0, 80.0)
    assert 2.0 * math.atan2(y, x) == pytest.approx(bearing, abs=0.2)  # looks at the region of interest


def test_a_mission_that_lands_disarms_and_begins_again() -> None:
    client = on_the_ground()
    assert upload(client, [item(22, up=5.0), item(21, 8.0, 0.0, 0.0, param4=NAN)])["type"] == 0
    client.run(0.1)
    assert client.command(START, 0.0) == ACCEPTED
    assert client.texts()[-1] in ("Armed by mission start\t", "Takeoff detected\t")
    client.run_until(lambda: not client.bridge.autopilot.commander.armed, 60.0)
    assert client.texts()[-1] == "Disarmed by landing\t"
    assert client.bridge.truth.p_n[0] == pytest.approx(8.0, abs=0.7)
    assert client.flown is Mode.MISSION
    client.run(0.1)
    assert client.command(ARM, 1) == ACCEPTED
    client.run(5.5)
    assert client.bridge.autopilot.missions.current == 0
    assert client.height > 0.3


def test_interrupted_and_gone_on_with() -> None:
    client = Client("sih")
    assert upload(client, SQUARE)["type"] == 0
    client.run(0.1)
    assert client.command(START, 5.0) == DENIED
    assert client.command(SET_CURRENT, 9.0) == FAILED
    assert client.command(SET_CURRENT, 1.0) == ACCEPTED
    client.run(0.1)
    assert client.last("MISSION_CURRENT")["seq"] == 1
    client.mode(Mode.MISSION)
    client.run(3.0)
    assert client.mode(Mode.HOLD) == ACCEPTED
    client.run(3.0)
    assert client.last("MISSION_CURRENT")["mission_mode"] == 2
    client.send("MISSION_SET_CURRENT", seq=2)
    client.mode(Mode.MISSION)
    assert [index for _, index in flown(client, 60.0)][:2] == [2, 3]
    client.send("MISSION_SET_CURRENT", seq=0)
    client.mode(Mode.MISSION)
    client.run(2.0)
    assert upload(client, [item(16, -10.0, 0.0, 10.0, param4=NAN)])["type"] == 0  # while it is flown
    flown(client, 60.0)
    client.run(9.0)
    assert client.bridge.truth.p_n[0] == pytest.approx(-10.0, abs=0.5)


@pytest.mark.parametrize(
    ("plan", "text"),
    [
        ([item(21)], None),  # PX4 tells of these in events only
        ([item(22, up=-3.0)], None),
        ([item(16, up=5.0), item(22, up=5.0)], None),
        ([item(84, up=5.0)], None),
        ([item(22, up=5.0), item(16, 200.0, 0.0, 5.0)], "Geofence violation for waypoint 2\t"),
    ],
)
def test_what_cannot_be_flown_is_found_when_it_comes_in(plan: list[dict[str, Any]], text: str | None) -> None:
    client = on_the_ground()
    assert upload(client, [item(5003, param1=100.0)], FENCE)["type"] == 0
    client.run(0.1)
    assert upload(client, plan)["type"] == 0
    client.run(0.1)
    assert client.texts() == ([] if text is None else [text])
    assert client.command(START, 0.0) == DENIED
    assert client.texts()[-1] == "Mission start denied! No valid mission\t"


def towards_the_fence(**parameters: float) -> Client:
    """A hover inside a fence, told to go far outside it."""
    client = Client("sih")
    client.ground_station()
    client.bridge.autopilot.parameters.update(parameters)
    if "GF_MAX_HOR_DIST" not in parameters:
        corners = ((-20, -20), (20, -20), (20, 20), (-20, 20))
        assert upload(client, [item(5001, n, e, param1=4.0) for n, e in corners], FENCE)["type"] == 0
    client.run(0.3)
    client.rates()
    assert client.mode(Mode.OFFBOARD) == ACCEPTED
    return client


@pytest.mark.parametrize(
    ("parameters", "mode"),
    [
        ({"GF_ACTION": 0}, Mode.OFFBOARD),
        ({"GF_ACTION": 1}, Mode.OFFBOARD),
        ({"GF_ACTION": 2}, Mode.HOLD),
        ({"GF_ACTION": 3, "COM_FAIL_ACT_T": 0.0}, Mode.RETURN),
        ({"GF_ACTION": 5, "GF_MAX_HOR_DIST": 15.0, "COM_FAIL_ACT_T": 0.0}, Mode.LAND),
    ],
)
def test_beyond_the_fence(parameters: dict[str, float], mode: Mode) -> None:
    client = towards_the_fence(**parameters)

    def lean() -> None:
        q = (math.cos(0.2), 0.0, -math.sin(0.2), 0.0)
        client.send("SET_ATTITUDE_TARGET", q=q, thrust=0.54, type_mask=0x07)

    client.run_until(lambda: lean() or client.bridge.truth.p_n[0] > parameters.get("GF_MAX_HOR_DIST", 20.0) + 2.0, 20.0)
    client.run(0.3, lean)
    assert client.flown is mode
    if parameters["GF_ACTION"]:
        expected = "maximum distance" if "GF_MAX_HOR_DIST" in parameters else "approaching or outside"
        assert any(expected in text for text in client.texts())


def test_an_orbit_keeps_its_distance_and_faces_its_centre() -> None:
    client = Client("sih")
    client.ground_station()
    client.run(1.0)
    assert not client.all("ORBIT_EXECUTION_STATUS")
    assert client.command(34, 10.0, 3.0, 0.0, 0.0, HOME[0], HOME[1], 489.4 + 12.0) == ACCEPTED
    client.run(25.0)
    assert len(client.all("ORBIT_EXECUTION_STATUS")) == pytest.approx(25 * 5, rel=0.03)
    circle = client.last("ORBIT_EXECUTION_STATUS", 1)
    assert (circle["radius"], circle["z"], circle["frame"]) == pytest.approx((10.0, 489.4 + 12.0, 0), abs=0.1)
    assert (circle["x"], circle["y"]) == pytest.approx((HOME[0] * 1e7, HOME[1] * 1e7), abs=50)  # a float of 47 deg
    north, east, down = client.bridge.truth.p_n
    assert math.hypot(north, east) == pytest.approx(10.0, abs=1.5)
    assert -down == pytest.approx(12.0, abs=0.5)
    vn, ve, _ = client.bridge.truth.v_n
    assert (north * ve - east * vn) / math.hypot(north, east) == pytest.approx(2.9, abs=0.6)  # clockwise
    assert client.command(34, 5000.0, NAN, NAN, 0.0, NAN, NAN, NAN) == ACCEPTED
    assert client.texts() == ["Orbit radius limit exceeded\t"]
    client.command(512, 0)
    heartbeat = client.last("HEARTBEAT")
    assert (heartbeat["base_mode"], heartbeat["custom_mode"]) == (0x91, 0x01030000)


def test_a_place_outside_the_fence_is_not_gone_to() -> None:
    client = Client("sih")
    client.ground_station()
    assert upload(client, [item(5003, param1=30.0)], FENCE)["type"] == 0
    client.run(0.3)
    assert client.command(192, -1.0, 1.0, 0.0, NAN, HOME[0] + 50.0 * METRE, HOME[1], 500.0) == ACCEPTED
    client.run(2.0)
    assert client.texts() == ["Reposition is outside geofence\t"]
    assert abs(client.bridge.truth.p_n[0]) < 0.5


def test_a_fence_without_its_home_does_not_count() -> None:
    client = Client("sih")
    client.ground_station()
    assert upload(client, [item(5003, 100.0, 0.0, param1=10.0)], FENCE)["type"] == 0
    client.run(0.5)
    assert client.texts() == ["Geofence invalid, doesn't contain Home position\t"]
    assert client.flown is Mode.HOLD


def test_every_link_hears_how_the_mission_goes() -> None:
    client = Client("sih")
    before = client.bridge.now
    client.run(5.0)
    for endpoint in (0, 1):
        assert len(client.all("MISSION_CURRENT", endpoint, since=before)) == pytest.approx(5, abs=1)
