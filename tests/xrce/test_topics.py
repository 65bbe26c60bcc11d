"""Samples of PX4's topics: names, versions, layouts."""

from __future__ import annotations

import math

import pytest

from companion.xrce import objects, topics, wire
from companion.xrce.objects import Create, WriteData
from companion.xrce.topics import LAYOUTS, Topic
from tests.xrce.captured import session


def test_mode_and_motors_are_the_bytes_that_px4_has_flown_on() -> None:
    """xrce.md, section 4: taken by PX4 main of March 2026."""
    mode = LAYOUTS["offboard_control_mode", 0].encode(direct_actuator=True)
    motors = LAYOUTS["actuator_motors", 0].encode(
        timestamp_sample=42_252_000, control=(0.49, 0.5, 0.51, 0.48, *[math.nan] * 8)
    )
    assert mode.hex() == "000000000000000000000000000001"
    assert motors.hex() == "0000000000000000e0b68402000000000000000048e1fa3e0000003f5c8f023f8fc2f53e" + "0000c07f" * 8


def test_every_topic_of_a_real_px4_that_is_spoken_here_is_known_in_its_version() -> None:
    created = [
        each
        for datagram in session()
        if datagram.of_client
        for each in wire.decode(datagram.data).submessages
        if isinstance(each, Create)
    ]
    found = {topic for name in map(objects.name_of, created) if name and (topic := topics.parse(name)) is not None}
    assert len([topic for topic in found if topic.to_px4]) == 38
    assert len([topic for topic in found if not topic.to_px4]) == 27
    spoken = {name for name, _ in LAYOUTS}
    assert spoken == {topic.name for topic in found} & spoken
    for topic in found:
        if topic.name in spoken:
            topics.layout(topic, versioned=True)


def test_what_px4_publishes_is_read_by_its_layout() -> None:
    """vehicle_control_mode of a vehicle on the ground: the offsets of xrce.md, section 6."""
    writers: dict[int, str] = {}
    samples: dict[str, bytes] = {}
    for datagram in session():
        for each in wire.decode(datagram.data).submessages:
            if isinstance(each, Create) and (name := objects.name_of(each)) is not None:
                writers[each.object >> 4] = name
            elif isinstance(each, WriteData):
                samples[writers[each.object >> 4]] = each.sample
    sample = samples["rt/fmu/out/vehicle_control_mode"]
    mode = LAYOUTS["vehicle_control_mode", 0].decode(sample)
    assert mode is not None
    assert mode["flag_control_offboard_enabled"] == bool(sample[12])
    assert mode["flag_control_allocation_enabled"] == bool(sample[20])
    status = LAYOUTS["vehicle_status", 2].decode(samples["rt/fmu/out/vehicle_status_v2"])
    assert status is not None
    assert status["nav_state"] == status["nav_state_user_intention"]


def test_names_and_versions_are_read_off_the_wire() -> None:
    assert topics.parse("rt/fmu/out/vehicle_status_v2") == Topic("vehicle_status", 2, to_px4=False)
    assert topics.parse("rt/px4_1/fmu/in/actuator_motors") == Topic("actuator_motors", 0, to_px4=True)
    assert topics.parse("rq/fmu/vehicle_commandRequest") is None
    for name in ("rt/fmu/out/vehicle_status_v2", "rt/fmu/in/actuator_motors"):
        topic = topics.parse(name)
        assert topic is not None
        assert topic.wire_name() == name
    assert Topic("a", 0, to_px4=True).wire_name("px4_1") == "rt/px4_1/fmu/in/a"


def test_a_version_that_is_not_known_is_refused_with_a_sentence() -> None:
    with pytest.raises(
        topics.TopicError, match=r"actuator_motors in version 1, .* version 0 of it is known here; take"
    ):
        topics.layout(Topic("actuator_motors", 1, to_px4=True), versioned=True)


def test_attitudes_have_three_layouts() -> None:
    """Euler angles went before 1.16, the two flags after it."""
    attitude = Topic("vehicle_attitude_setpoint", 0, to_px4=True)
    sizes = [
        topics.layout(attitude, versioned=False).size,
        topics.layout(attitude, versioned=True).size,
        topics.layout(attitude._replace(version=1), versioned=True).size,
    ]
    assert sizes == [54, 42, 40]


@pytest.mark.parametrize("key", LAYOUTS, ids=str)
def test_a_sample_is_read_as_it_was_written(key: tuple[str, int]) -> None:
    layout = LAYOUTS[key]
    values = layout.decode(layout.pack(*layout.zero))
    assert values is not None
    values["timestamp"] = 1 << 40
    assert layout.decode(layout.encode(**values) + b"more") == values
    assert layout.decode(bytes(layout.size - 1)) is None
