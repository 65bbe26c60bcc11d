"""The stand-in's XRCE client against what PX4's own was captured saying, and against an agent that comes and goes."""

from __future__ import annotations

import pytest

from companion.world import Link, Way, World
from companion.xrce.messages import Submessage
from companion.xrce.objects import Create, WriteData, name_of, topic_of
from companion.xrce.wire import decode
from sim_bridge.autopilot.xrce import Release
from sim_bridge.autopilot.xrce.topic_table import table_of
from tests.support.xrce_agent import XrceClient, motors, offboard_mode
from tests.xrce.captured import session

RELIABLE = 0x80


def demanded(messages: list[tuple[int, tuple[Submessage, ...]]]) -> list[object]:
    """What a client demands, message by message; of its objects what they are (a real client leaves old bytes between
    two strings)."""
    found = []
    for stream, submessages in messages:
        if stream == RELIABLE:
            found.append([
                (each.request, each.object, each.kind, each.form, each.parent, name_of(each), topic_of(each),
                 len(each.representation)) if isinstance(each, Create) else each
                for each in submessages
            ])  # fmt: skip
    return found


def test_it_demands_what_the_real_client_was_captured_demanding() -> None:
    captured = [decode(each.data) for each in session() if each.of_client]
    vehicle = XrceClient(synct=1)
    vehicle.connect(8.0)
    vehicle.run(0.1)
    theirs = demanded([(each.stream, each.submessages) for each in captured])
    ours = demanded([(each.stream, each.submessages) for _, each in vehicle.said])
    assert len(theirs) > 60
    assert ours == theirs


def test_its_samples_are_as_long_as_the_real_clients() -> None:
    names: dict[int, str | None] = {}
    theirs: dict[str | None, int] = {}
    for message in (decode(each.data) for each in session() if each.of_client):
        for said in message.submessages:
            if isinstance(said, Create) and name_of(said) is not None:
                names[said.object >> 4] = name_of(said)
            elif isinstance(said, WriteData):
                theirs[names[said.object >> 4]] = len(said.sample)
    vehicle = XrceClient()
    vehicle.connect()
    vehicle.run(1.0)
    ours = {f"rt/fmu/out/{name}": len(samples[-1][1]) for name, samples in vehicle.samples.items()}
    assert len(ours) >= 8
    assert ours.items() <= theirs.items()


def test_it_publishes_at_the_real_clients_rates() -> None:
    vehicle = XrceClient()
    vehicle.connect()
    vehicle.run(4.0)
    rates = {name: len(samples) / 4.0 for name, samples in vehicle.samples.items()}
    for name, measured in (("vehicle_odometry", 99.0), ("sensor_combined", 99.0), ("vehicle_attitude", 50.0),
                           ("vehicle_local_position_v1", 50.0)):  # fmt: skip
        assert rates[name] == pytest.approx(measured, rel=0.03), name
    assert rates["vehicle_control_mode"] == pytest.approx(2.0, abs=0.3)
    assert rates["vehicle_status_v2"] == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize(("release", "place"), [(Release.V1_15, 26), (Release.V1_16, 24), (Release.MAIN, 24)])
def test_the_motors_reader_has_its_place_of_the_release(release: Release, place: int) -> None:
    vehicle = XrceClient(release=release)
    vehicle.connect()
    assert vehicle.readers["actuator_motors"] == 0x8006 + 16 * place
    assert len(vehicle.readers) == len(table_of(release).taken)


def test_with_synct_it_asks_for_the_time_until_500_answers_came_in_time() -> None:
    vehicle = XrceClient(synct=1)
    took = vehicle.connect(10.0)
    assert took == pytest.approx(6.2, abs=0.6)
    late = XrceClient(world=World(link=Link(Way(delay=0.006), Way(delay=0.006))), synct=1)
    late.run(9.0)
    assert not late.client.serves
    assert not late.readers  # main waits before it makes anything, 1.15 after


def test_a_line_that_loses_one_in_seven_each_way_stands_within_five_seconds() -> None:
    vehicle = XrceClient(loss=0.15)
    steps = [0]

    def now_and_then() -> None:
        steps[0] += 1
        if steps[0] % 25 == 0:
            vehicle.remind()

    vehicle.run(5.0, now_and_then)
    assert vehicle.client.serves
    assert len(vehicle.readers) == len(table_of(Release.MAIN).taken)


def test_a_silent_agent_is_given_up_after_three_pings_and_a_new_one_found() -> None:
    vehicle = XrceClient()
    vehicle.connect()
    vehicle.run(2.5)
    assert vehicle.client.serves  # pings are answered though nothing is written
    vehicle.dead = True
    gone = vehicle.run_until(lambda: vehicle.ended, 8.0)
    assert 3.0 < gone < 6.5
    vehicle.dead = False
    assert vehicle.connect() < 2.0
    assert vehicle.readers["actuator_motors"] == 0x8186


def test_a_new_agent_may_go_on_with_a_session_that_stands() -> None:
    vehicle = XrceClient()
    vehicle.connect()
    mode, commands = offboard_mode("direct_actuator"), vehicle.bridge.autopilot.commands
    vehicle.in_offboard(mode, motors(*commands))
    vehicle.skip_to(0x4000)  # a process that does not know the number it was at: a quarter of the circle on
    vehicle.write(mode, motors(0.5, 0.51, 0.52, 0.53))
    vehicle.run(0.02)
    assert vehicle.bridge.autopilot.commands == pytest.approx((0.5, 0.51, 0.52, 0.53))
    vehicle.skip_to(0x3FF0)  # what is older than the last is not read
    vehicle.write(mode, motors(0.4, 0.4, 0.4, 0.4))
    vehicle.run(0.02)
    assert vehicle.bridge.autopilot.commands == pytest.approx((0.5, 0.51, 0.52, 0.53))
