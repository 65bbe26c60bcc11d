"""Bytes <-> messages, against the bytes of a real session, and against garbage."""

from __future__ import annotations

import pytest

from companion.xrce import objects, wire
from companion.xrce.messages import (
    Acknack,
    CreateClient,
    Delete,
    Fragment,
    GetInfo,
    Heartbeat,
    Info,
    StatusAgent,
    Submessage,
    Timestamp,
    TimestampReply,
)
from companion.xrce.objects import Create, Data, Kind, ReadData, Status, WriteData
from tests.xrce.captured import session
from tests.xrce.small_client import fragments


def test_every_message_of_a_real_session_is_read_and_written_back() -> None:
    """The agent's byte for byte; the client leaves what lies in its padding, and does not fill its last one up."""
    for each in session():
        written = wire.encode(wire.decode(each.data))
        if each.of_client:
            assert wire.decode(written) == wire.decode(each.data)
            assert len(each.data) <= len(written) < len(each.data) + 4
        else:
            assert written == each.data


@pytest.mark.parametrize(
    "value",
    [
        CreateClient(b"\0\0\0\x08", mtu=508),
        StatusAgent(),
        GetInfo(10, 0xFFFD),
        Info(10, 0xFFFD, alive=True),
        Create(11, 0x8002, Kind.TOPIC, 3, b"odd", 0x0011),
        Status(11, 0x8002, 1),
        ReadData(14, 0x8006),
        WriteData(0, 0x0D25, b"sample"),
        Data(0, 0x8186, b""),
        Delete(2, 0xFFFE),
        Acknack(0xFFFF, 0b101),
        Heartbeat(65530, 3),
        Fragment(b"piece"),
        Fragment(b"piece", last=True),
        Timestamp(b"12345678"),
        TimestampReply(b"12345678", b"abcdefgh", b"ABCDEFGH"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_one_side_writes_the_other_reads(value: Submessage) -> None:
    message = wire.Message(0x81, 0x80, 513, (value, Status(1, 2)))
    assert wire.decode(wire.encode(message)) == message


def test_the_stand_in_describes_its_objects_as_the_client_does() -> None:
    """But for what lies in the client's padding."""
    told = [
        each
        for datagram in session()
        if datagram.of_client
        for each in wire.decode(datagram.data).submessages
        if isinstance(each, Create)
    ]
    topic = next(each for each in told if objects.name_of(each) == "rt/fmu/in/mode_completed")
    number, request = topic.object >> 4, topic.request
    _, subscriber, reader = told[told.index(topic) : told.index(topic) + 3]
    made = objects.topic(request, number, "rt/fmu/in/mode_completed", "px4_msgs::msg::dds_::ModeCompleted_")
    assert (made.object, made.parent, len(made.body())) == (topic.object, topic.parent, len(topic.body()))
    assert objects.name_of(made) == objects.name_of(topic)
    assert objects.group(subscriber.request, number, Kind.SUBSCRIBER) == subscriber
    built = objects.reader(reader.request, number)
    assert objects.topic_of(built) == objects.topic_of(reader) == topic.object
    assert (built.object, built.parent, len(built.body())) == (reader.object, reader.parent, len(reader.body()))


def test_a_submessage_in_pieces_is_the_same_whole() -> None:
    whole = objects.topic(
        11, 0x800, "rt/" + "n" * 60 + "/fmu/in/actuator_motors", "px4_msgs::msg::dds_::ActuatorMotors_"
    )
    pieces = list(fragments(whole, 48))
    assert [each.last for each in pieces] == [False] * (len(pieces) - 1) + [True]
    assert all(len(each.piece) <= 48 for each in pieces)
    assert list(wire.decode_submessages(b"".join(each.piece for each in pieces))) == [whole]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x81\x01\0",
        b"\x01\x01\0\0",  # a key in the header
        b"\x81\x01\0\0\x07",  # half a header
        b"\x81\x01\0\0\x07\x01\x08\0\0\0",  # cut short
        b"\x81\x01\0\0\x07\x00\x04\0\0\0\0\0",  # big endian
        b"\x81\x01\0\0\x07\x01\x02\0\0\0\0\0",  # no room for an id
        b"\x81\x80\0\0\x01\x01\x0c\0\0\0\0\0\x02\x03\0\0\xff\xff\xff\xff",  # a topic of 4 GB
        b"\x80\0\0\0\0\x01\x10\0YRCE" + bytes(12),  # not the cookie
    ],
)
def test_half_a_message_is_none(data: bytes) -> None:
    with pytest.raises(wire.WireError):
        wire.decode(data)


def test_samples_are_encoded_as_their_values_are() -> None:
    samples = [(10, 0x8096, bytes(15)), (11, 0x8186, bytes(range(68))), (12, 0x8166, b"")]
    values = tuple(objects.Data(*each) for each in samples)
    ids = [(request.to_bytes(2, "big") + number.to_bytes(2, "big"), cdr) for request, number, cdr in samples]
    assert wire.encode_samples(0x81, 77, ids) == wire.encode(wire.Message(0x81, 1, 77, values))


def test_a_submessage_nobody_knows_is_passed_over() -> None:
    message = wire.decode(b"\x81\x01\x05\0\x42\x01\x03\0abc\0" + wire.encode_submessage(Heartbeat(1, 2)))
    assert message == wire.Message(0x81, 1, 5, (Heartbeat(1, 2),))
