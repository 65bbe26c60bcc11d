"""The lean codec against pymavlink, byte for byte, and against garbage."""

from __future__ import annotations

import math
import random
import struct

import pytest
from pymavlink.dialects.v20 import development as pymavlink

from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import BY_NAME, FORMATS, Format, Value, _declare
from trials.damaged_datagrams import fuzz, random_values

EXTENDED_BY_US = {"SET_ATTITUDE_TARGET", "MISSION_CURRENT", "MISSION_COUNT", "MISSION_ACK"}
KNOWN_TO_PYMAVLINK = [FORMATS[i] for i in sorted(pymavlink.mavlink_map) if FORMATS[i].name not in EXTENDED_BY_US]


def repacked(fmt: Format, values: tuple[Value, ...]) -> bytes:
    """The payload, so that NaN compares equal to itself."""
    return fmt.pack(*values)


def pymavlink_frame(fmt: Format, values: tuple[Value, ...], sequence: int) -> bytes:
    mav = pymavlink.MAVLink(None, srcSystem=7, srcComponent=191)
    mav.seq = sequence
    by_name = {}
    for field in fmt.fields:
        value = values[fmt.where[field]]
        by_name[field] = list(value) if isinstance(value, tuple) else value
    message = pymavlink.mavlink_map[fmt.id](**by_name)
    return message.pack(mav, force_mavlink1=False)


@pytest.mark.parametrize("fmt", KNOWN_TO_PYMAVLINK, ids=lambda f: f.name)
def test_encodes_and_decodes_as_pymavlink_does(fmt: Format) -> None:
    rng = random.Random(fmt.id)
    for zeros in (0.0, 0.5, 0.95, 1.0):
        values = random_values(fmt, rng, zeros)
        sequence = rng.randrange(256)
        ours = Encoder(7, 191, sequence).encode(fmt, values)
        theirs = pymavlink_frame(fmt, values, sequence)
        assert ours == theirs
        (frame,) = Decoder().datagram(theirs)
        assert frame.format is fmt
        assert (frame.system, frame.component) == (7, 191)
        assert repacked(fmt, frame.values) == repacked(fmt, values)
        decoded = pymavlink.MAVLink(None).parse_buffer(bytearray(ours))
        assert decoded is not None
        assert decoded[0].get_msgId() == fmt.id


@pytest.mark.parametrize("name", ["HEARTBEAT", "ODOMETRY", "STATUSTEXT", "COMMAND_LONG", "MISSION_ITEM_INT"])
def test_our_rule_for_crc_extras_gives_pymavlinks_numbers(name: str) -> None:
    message = pymavlink.mavlink_map[BY_NAME[name].id]
    kinds = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
    lengths = dict(zip(message.ordered_fieldnames, message.array_lengths, strict=True))
    extensions = {"ODOMETRY": 3, "STATUSTEXT": 2, "MISSION_ITEM_INT": 1}.get(name, 0)
    fields = [f"{kinds[f]} {f}[{lengths[f]}]" if lengths[f] else f"{kinds[f]} {f}" for f in message.fieldnames]
    base, extra = fields[: len(fields) - extensions], fields[len(fields) - extensions :]
    declared = _declare(message.id, name, ", ".join(base), ", ".join(extra))
    assert declared.crc_extra == message.crc_extra
    assert declared.fields == tuple(message.ordered_fieldnames)


def test_messages_pymavlink_lacks() -> None:
    """CRC extras as published for MAVLink's common.xml."""
    assert BY_NAME["EVENT"].crc_extra == 160
    assert BY_NAME["CURRENT_EVENT_SEQUENCE"].crc_extra == 106
    assert BY_NAME["PARAM_ERROR"].crc_extra == 209
    attitude_target = BY_NAME["SET_ATTITUDE_TARGET"]
    assert attitude_target.crc_extra == pymavlink.mavlink_map[82].crc_extra
    values = attitude_target.values(q=(1, 0, 0, 0), body_roll_rate=0.5, thrust=0.25, type_mask=128)
    message = pymavlink.MAVLink_set_attitude_target_message(0, 0, 0, 128, [1, 0, 0, 0], 0.5, 0, 0, 0.25)
    assert Encoder(1, 1).encode(attitude_target, values) == message.pack(pymavlink.MAVLink(None, 1, 1))


def test_reads_mavlink_1_and_signed_frames() -> None:
    mav = pymavlink.MAVLink(None, srcSystem=3, srcComponent=4)
    heartbeat = pymavlink.MAVLink_heartbeat_message(2, 12, 81, 50593792, 3, 3)
    (frame,) = Decoder().datagram(heartbeat.pack(mav, force_mavlink1=True))
    assert frame.format.named(frame.values)["custom_mode"] == 50593792
    mav.signing.secret_key = bytes(range(32))
    mav.signing.sign_outgoing = True
    signed = heartbeat.pack(mav)
    assert signed[2] == 1
    (frame,) = Decoder().datagram(signed)
    assert frame.raw == signed


def test_several_frames_and_garbage_in_one_datagram() -> None:
    encoder = Encoder(1, 1)
    frames = [encoder.message(BY_NAME["HEARTBEAT"], type=i) for i in range(3)]
    decoder = Decoder()
    found = decoder.datagram(b"\xfd\x00" + frames[0] + b"\x12\xfe\x34" + frames[1] + frames[2] + b"\xfd\xff")
    assert [f.raw for f in found] == frames
    assert decoder.counters.garbage_bytes == 2 + 3 + 2
    assert decoder.counters.lost == 0


def test_a_datagrams_leftovers_do_not_touch_the_next() -> None:
    frame = Encoder(1, 1).message(BY_NAME["HEARTBEAT"], type=2)
    decoder = Decoder()
    assert decoder.datagram(frame[:-1]) == []
    assert [f.raw for f in decoder.datagram(frame)] == [frame]


def test_a_stream_in_pieces_gives_every_frame() -> None:
    rng = random.Random(1)
    encoder = Encoder(1, 1)
    formats = [BY_NAME[n] for n in ("ODOMETRY", "HEARTBEAT", "ATTITUDE_QUATERNION", "STATUSTEXT")]
    sent = [encoder.encode(f, random_values(f, rng, 0.3)) for f in rng.choices(formats, k=300)]
    data = b"".join(piece + (bytes(rng.choices(range(0xFD), k=3)) if rng.random() < 0.2 else b"") for piece in sent)
    decoder = Decoder()
    found: list[Frame] = []
    at = 0
    while at < len(data):
        step = rng.randrange(1, 90)
        found += decoder.stream(data[at : at + step])
        at += step
    assert [f.raw for f in found] == sent


def test_lost_frames_are_counted_by_sequence() -> None:
    encoder = Encoder(1, 1, sequence=250)
    frames = [encoder.message(BY_NAME["HEARTBEAT"]) for _ in range(20)]
    decoder = Decoder()
    for i, frame in enumerate(frames):
        if i not in (3, 4, 10):
            decoder.datagram(frame)
    assert decoder.counters.lost == 3
    decoder.datagram(frames[4])  # late, and so not lost
    assert decoder.counters.lost == 2
    decoder.datagram(frames[-1])  # twice
    assert decoder.counters.lost == 2


def test_only_wanted_messages_are_unpacked() -> None:
    encoder = Encoder(1, 1)
    decoder = Decoder(wanted={0})
    frames = decoder.datagram(encoder.message(BY_NAME["ATTITUDE"]) + encoder.message(BY_NAME["HEARTBEAT"]))
    assert [f.format.name for f in frames] == ["HEARTBEAT"]
    assert decoder.counters.frames == 2


def test_mutated_datagrams_raise_nothing_and_hide_no_good_frame() -> None:
    """A seeded tenth of bench/fuzz_codec.py."""
    assert fuzz(100_000, seed=7) == 0


def test_values_by_name_and_back() -> None:
    fmt = BY_NAME["STATUSTEXT"]
    named = fmt.named(fmt.values(severity=6, text="Armed by external command\t"))
    assert named["text"] == "Armed by external command\t"
    odometry = BY_NAME["ODOMETRY"]
    assert odometry.named(odometry.values(q=(1.0, 0.0, 0.0, 0.0)))["q"] == (1.0, 0.0, 0.0, 0.0)
    with pytest.raises(KeyError):
        fmt.values(nonsense=1)
    with pytest.raises(ValueError, match="takes 4 values"):
        odometry.values(q=(1.0, 0.0))
    assert math.isnan(odometry.values(x=math.nan)[1])


def test_what_goes_on_the_wire_is_clamped_to_its_type() -> None:
    target, named = BY_NAME["SET_ATTITUDE_TARGET"], BY_NAME["NAMED_VALUE_FLOAT"]
    encoded = Encoder(1, 1).message(target, time_boot_ms=2**40, body_roll_rate=3.5e38, thrust=-1e300, type_mask=999)
    (frame,) = Decoder().datagram(encoded)
    values = target.named(frame.values)
    assert (values["time_boot_ms"], values["type_mask"]) == (2**32 - 1, 255)
    assert values["body_roll_rate"] == -values["thrust"] == pytest.approx(3.4028234663852886e38)
    actuators = BY_NAME["SET_ACTUATOR_CONTROL_TARGET"]
    for stamp, on_wire in ((2.0**64, 2**64 - 1), (-1.0, 0), (math.nan, 0), (math.inf, 2**64 - 1)):
        (frame,) = Decoder().datagram(Encoder(1, 1).message(actuators, time_usec=stamp))
        assert frame.values[0] == on_wire
    (frame,) = Decoder().datagram(Encoder(1, 1).message(named, value=1e39, name="pf_path", time_boot_ms=1))
    assert named.named(frame.values)["name"] == "pf_path"
    (frame,) = Decoder().datagram(Encoder(1, 1).message(BY_NAME["MISSION_ITEM_INT"], x=-(2**40), y=2**31))
    where = frame.format.where
    assert (frame.values[where["x"]], frame.values[where["y"]]) == (-(2**31), 2**31 - 1)
    with pytest.raises(struct.error):
        Encoder(1, 1).encode(named, (1, 2.0, "not bytes"))
