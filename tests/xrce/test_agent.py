"""The conversation with PX4's client: a captured one, a lossy one, a spoilt one."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from companion.xrce import wire
from companion.xrce.agent import Agent
from companion.xrce.messages import SESSION, THE_CLIENT, Delete, Fragment, GetInfo, Heartbeat, Info
from companion.xrce.objects import Status, WriteData, topic
from companion.xrce.topics import LAYOUTS
from companion.xrce.wire import NO_STREAM, Message
from tests.xrce.captured import session
from tests.xrce.small_client import SmallClient, fragments
from trials.damaged_xrce import fuzz

IN = ["offboard_control_mode", "actuator_motors", "vehicle_thrust_setpoint"]
STEP = 0.001
"""s."""


def replayed() -> tuple[Agent, list[bytes], list[tuple[str, bytes]]]:
    """An agent after the captured session, its answers, and the samples it read."""
    agent, answers, samples = Agent(), [], []
    for each in session():
        if each.of_client:
            samples += [(sample.topic.name, sample.cdr) for sample in agent.receive(each.data, each.at)]
            answers += agent.datagrams(each.at)
    return agent, answers, samples


def test_the_captured_session_gives_the_same_answers_reader_ids_and_topics() -> None:
    """Heartbeats are sent by a timer; here none is due, since the client acknowledged at once."""
    agent, answers, samples = replayed()
    told = [each.data for each in session() if not each.of_client]
    assert answers == [data for data in told if not isinstance(wire.decode(data).submessages[0], Heartbeat)]
    assert len(agent.reading) == 38
    assert agent.reading["actuator_motors"].object == 0x8186
    assert agent.reading["offboard_control_mode"].object == 0x8096
    assert agent.versioned
    assert len(samples) == 150
    assert {name for name, _ in samples} >= {"vehicle_control_mode", "vehicle_status", "vehicle_odometry"}
    assert agent.counters.garbage == agent.counters.late == agent.counters.lost == 0


def test_mode_and_motors_go_out_in_one_message() -> None:
    """Byte for byte what PX4 has flown on, but for the sequence number and the request of mode and motors."""
    agent, _, _ = replayed()
    mode = LAYOUTS["offboard_control_mode", 0].encode(direct_actuator=True)
    motors = LAYOUTS["actuator_motors", 0].encode(timestamp_sample=42_252_000, control=(0.5,) * 12)
    assert agent.write([("offboard_control_mode", mode), ("actuator_motors", motors)])
    (data,) = agent.datagrams(27.0)
    assert len(data) == 104
    assert data[:7].hex() == "81010000090113"
    assert data[10:12].hex() == "8096"
    assert not agent.write([("offboard_control_mode", mode), ("no_such_topic", b"")])
    assert agent.datagrams(27.0) == []


def connect(
    loss: float, *, timesync: bool, limit: float, seed: int = 1
) -> tuple[float, Agent, SmallClient, Callable[[], None]]:
    """The time (s) until a client stands, and both sides; a function that goes on for a step."""
    rng = random.Random(seed)
    agent = Agent()
    client = SmallClient([f"rt/fmu/in/{name}" for name in IN] + [f"rt/fmu/in/t{i}" for i in range(35)],
                         [f"rt/fmu/out/u{i}" for i in range(27)], timesync=timesync)  # fmt: skip
    now = 0.0

    def step() -> None:
        nonlocal now
        now += STEP
        for data in client.datagrams(now):
            if rng.random() >= loss:
                agent.receive(data, now)
        for data in agent.datagrams(now):
            if rng.random() >= loss:
                client.receive(data)

    while not client.ready:
        step()
        assert now < limit, "not connected in time"
    return now, agent, client, step


@pytest.mark.parametrize(("timesync", "limit"), [(False, 5.0), (True, 15.0)], ids=["SYNCT 0", "SYNCT 1"])
def test_connects_through_a_link_that_loses_15_percent_each_way(timesync: bool, limit: float) -> None:
    took, agent, client, step = connect(0.15, timesync=timesync, limit=limit)
    print(f"connected after {took:.1f} s")
    assert agent.sessions == 1
    assert len(agent.reading) == 38
    assert took > (5.0 if timesync else 0.0)
    assert agent.write([("actuator_motors", b"motors"), ("offboard_control_mode", b"mode")])
    before = agent.counters.lost
    for _ in range(200):
        client.publish("rt/fmu/out/u3", b"sample")
        step()
    assert 10 <= agent.counters.lost - before <= 60


def test_a_session_goes_on_where_the_agent_was_away_for_a_while() -> None:
    """Its socket was closed and opened again: the next datagram is read."""
    _, agent, client, step = connect(0.0, timesync=False, limit=5.0)
    agent.write([("actuator_motors", b"before")])
    step()
    agent.write([("actuator_motors", b"lost")])
    agent.datagrams(9.0)  # into a closed socket
    agent.write([("actuator_motors", b"after")])
    step()
    assert client.read == [("rt/fmu/in/actuator_motors", b"before"), ("rt/fmu/in/actuator_motors", b"after")]


def test_a_client_that_is_not_known_is_told_that_its_session_is_gone() -> None:
    agent = Agent()
    agent.receive(wire.encode(Message(SESSION, NO_STREAM, 0, (GetInfo(10, 0xFFFD),))), 0.0)
    (answer,) = agent.datagrams(0.0)
    assert wire.decode(answer) == Message(SESSION, NO_STREAM, 0, (Info(10, 0xFFFD, alive=False),))


def test_a_client_that_leaves_is_told_so_and_nothing_more_is_written() -> None:
    agent, _, _ = replayed()
    agent.receive(wire.encode(Message(SESSION, NO_STREAM, 0, (Delete(2, THE_CLIENT),))), 30.0)
    assert [wire.decode(data).submessages for data in agent.datagrams(30.0)] == [(Status(2, THE_CLIENT),)]
    assert not agent.connected
    assert not agent.write([("actuator_motors", b"")])


def test_what_comes_late_has_no_effect() -> None:
    agent, _, _ = replayed()
    old = next(each.data for each in session() if each.of_client and each.data[1] == 1)
    assert agent.receive(old, 27.0) == []
    assert agent.counters.late == 1


def test_objects_that_come_in_pieces_are_made() -> None:
    """As with a long namespace and a short message (UXRCE_DDS_PTCFG 1, xrce.md section 3)."""
    agent, _, _ = replayed()
    whole = topic(500, 0x8FF, "rt/" + "n" * 60 + "/fmu/in/long", "px4_msgs::msg::dds_::Long_")
    first = max(wire.decode(each.data).sequence for each in session() if each.of_client and each.data[1] == 0x80) + 1
    pieces: list[Fragment] = list(fragments(whole, 40))
    for number, piece in enumerate(pieces):
        assert agent.datagrams(30.0) == [] or number
        agent.receive(wire.encode(Message(SESSION, 0x80, first + number, (piece,))), 30.0)
    answers = [each for data in agent.datagrams(30.0) for each in wire.decode(data).submessages]
    assert Status(500, whole.object) in answers


def test_spoilt_datagrams_raise_nothing() -> None:
    """The first of the million in bench/fuzz_xrce.py."""
    client = [each.data for each in session() if each.of_client]
    assert fuzz(client, 15_000, seed=2026) > 0


def test_a_sample_of_a_writer_nobody_made_is_none() -> None:
    agent, _, _ = replayed()
    stray = Message(SESSION, 1, 40_000, (WriteData(0, 0x7775, b"?"),))
    assert agent.receive(wire.encode(stray), 30.0) == []
