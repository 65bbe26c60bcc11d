"""Signing against pymavlink's, byte for byte; what is refused; what it costs is in bench/codec.py."""

from __future__ import annotations

import random

import pytest
from pymavlink.dialects.v20 import development as pymavlink

from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import BY_NAME, FORMATS
from companion.mavlink.signing import BEHIND_MAX, EPOCH, STREAMS_MAX, TICK, RefusedFrames, Signing
from tests.mavlink.test_codec import pymavlink_frame, random_values

KEY = bytes(range(7, 39))
NOW = 1_790_000_000.0
HEARTBEAT, RADIO_STATUS, COMMAND = BY_NAME["HEARTBEAT"], BY_NAME["RADIO_STATUS"], BY_NAME["COMMAND_LONG"]
KNOWN_TO_PYMAVLINK = [FORMATS[i] for i in sorted(pymavlink.mavlink_map) if FORMATS[i].name != "SET_ATTITUDE_TARGET"]


def side(key: bytes = KEY, link: int = 0, at: float = NOW) -> Signing:
    signing = Signing(key, link)
    signing.advance(at)
    return signing


def theirs(stamp: int, link: int = 3) -> pymavlink.MAVLink:
    mav = pymavlink.MAVLink(None, srcSystem=7, srcComponent=191)
    mav.signing.secret_key = KEY
    mav.signing.link_id = link
    mav.signing.timestamp = stamp
    mav.signing.sign_outgoing = True
    return mav


def test_a_stamp_counts_ten_microseconds_since_2015() -> None:
    assert side(at=EPOCH + 1.0).stamp == round(1.0 / TICK) == 100_000
    assert side(at=0.0).stamp == 0


@pytest.mark.parametrize("seed", range(5))
def test_signs_as_pymavlink_does_byte_for_byte_and_each_accepts_the_other(seed: int) -> None:
    rng = random.Random(seed)
    ours = side(link=3)
    encoder = Encoder(7, 191, signing=ours)
    mav = theirs(ours.stamp + 1)
    checking = pymavlink.MAVLink(None)
    checking.signing.secret_key = KEY
    checking.signing.timestamp = ours.stamp - 5
    decoder = Decoder(signing=side(at=NOW - 1.0))
    for fmt in rng.sample(KNOWN_TO_PYMAVLINK, 60):
        values = random_values(fmt, rng, 0.5)
        by_name = {}
        for field in fmt.fields:
            value = values[fmt.where[field]]
            by_name[field] = list(value) if isinstance(value, tuple) else value
        mav.seq, mav.signing.timestamp = encoder.sequence, ours.stamp + 1
        frame = encoder.encode(fmt, values)
        if fmt.name not in ("MISSION_CURRENT", "MISSION_COUNT", "MISSION_ACK"):  # we know more fields than pymavlink
            assert frame == pymavlink.mavlink_map[fmt.id](**by_name).pack(mav)
            (decoded,) = checking.parse_buffer(bytearray(frame)) or []
            assert decoded.get_signed()
        if fmt.name == "RADIO_STATUS":
            continue
        (found,) = decoder.datagram(frame)
        assert found.raw == frame
        assert fmt.pack(*found.values) == fmt.pack(*values)
    assert decoder.signing is not None
    assert decoder.signing.refused == RefusedFrames()
    assert decoder.signing.stamp == ours.stamp  # the later clock is followed


def test_without_a_key_signed_frames_are_read_and_frames_are_not_signed() -> None:
    frame = Encoder(1, 1, signing=side()).message(HEARTBEAT, type=2)
    assert [found.raw for found in Decoder().datagram(frame)] == [frame]
    assert Encoder(1, 1).message(HEARTBEAT)[2] == 0


def command(signing: Signing | None = None, component: int = 1) -> bytes:
    return Encoder(1, component, signing=signing).message(COMMAND, command=400, param1=1.0)


def test_unsigned_forged_and_replayed_frames_have_no_effect_and_are_counted() -> None:
    signing = side()
    taken: list[bytes] = []
    decoder = Decoder(signing=signing, tap=taken.append)
    good = command(side(at=NOW + 1.0))
    mav1 = pymavlink.MAVLink_heartbeat_message(2, 12, 81, 0, 3, 3).pack(pymavlink.MAVLink(None, 1, 1), True)
    foreign = command(side(bytes(32)))
    assert decoder.datagram(command()) == decoder.datagram(mav1) == decoder.datagram(foreign) == []
    assert (signing.refused.unsigned, signing.refused.forged) == (2, 1)
    assert [found.raw for found in decoder.datagram(good)] == [good]
    assert decoder.datagram(good) == []
    assert signing.refused == RefusedFrames(unsigned=2, forged=1, replayed=1)
    for at in range(len(good) - 13, len(good)):  # the link, the stamp, the digest: nothing can be changed
        assert decoder.datagram(good[:at] + bytes([good[at] ^ 1]) + good[at + 1 :]) == []
    assert signing.refused.forged == 1 + 13
    assert taken == [good]
    assert decoder.counters.frames == 1


def test_a_radio_tells_of_its_link_without_a_key_and_nothing_else_may() -> None:
    decoder = Decoder(signing=side())
    plain = Encoder(51, 68)
    assert len(decoder.datagram(plain.message(RADIO_STATUS, rssi=7))) == 1
    rng = random.Random(2)
    for fmt in FORMATS.values():
        if fmt is not RADIO_STATUS:
            assert decoder.datagram(plain.encode(fmt, random_values(fmt, rng, 0.5))) == []


def test_an_old_stream_is_refused_and_so_is_a_clock_that_was_set_back() -> None:
    signing = side()
    decoder = Decoder(signing=signing)
    minute = BEHIND_MAX * TICK
    assert decoder.datagram(command(side(at=NOW - minute - 1.0))) == []
    assert len(decoder.datagram(command(side(at=NOW - minute + 1.0)))) == 1  # a new stream may be a little behind
    assert len(decoder.datagram(command(side(at=NOW - minute + 2.0)))) == 1
    assert decoder.datagram(command(side(at=NOW - minute + 1.5))) == []
    assert len(decoder.datagram(command(side(at=NOW - minute + 1.5), component=2))) == 1  # another stream
    signing.advance(NOW - 1000.0)
    assert signing.stamp >= side().stamp


def test_stamps_survive_a_restart() -> None:
    signing = side()
    decoder = Decoder(signing=signing)
    heard = command(side(at=NOW + 5.0))
    decoder.datagram(heard)
    again = Signing(KEY, stamp=signing.stamp, streams=dict(signing.streams))
    again.advance(NOW - 86400.0)  # a computer without a clock of its own
    assert Decoder(signing=again).datagram(heard) == []
    assert again.refused.replayed == 1
    before = int.from_bytes(Encoder(1, 191, signing=signing).message(HEARTBEAT)[-12:-6], "little")
    after = int.from_bytes(Encoder(1, 191, signing=again).message(HEARTBEAT)[-12:-6], "little")
    assert after >= before


def test_the_key_is_in_no_text_and_no_tap() -> None:
    signing = side()
    assert KEY.hex() not in repr(signing)
    assert str(KEY) not in repr(signing)
    taken: list[bytes] = []
    setup = Encoder(255, 190).message(BY_NAME["SETUP_SIGNING"], secret_key=tuple(KEY), initial_timestamp=7)
    assert KEY in setup
    (found,) = Decoder(tap=taken.append).datagram(setup)
    assert found.format.name == "SETUP_SIGNING"
    assert taken == []


def test_streams_are_bounded() -> None:
    signing = side()
    decoder = Decoder(signing=signing)
    for system in range(1, STREAMS_MAX + 20):
        decoder.datagram(Encoder(system, 1, signing=side(at=NOW + system)).message(HEARTBEAT))
    assert len(signing.streams) == STREAMS_MAX


def test_signed_frames_cut_anywhere_and_among_garbage() -> None:
    rng = random.Random(9)
    encoder = Encoder(1, 1, signing=side(at=NOW + 1.0))
    sent = [encoder.encode(HEARTBEAT, random_values(HEARTBEAT, rng, 0.3)) for _ in range(100)]
    data = b"".join(frame + (b"\xfd\x01" if rng.random() < 0.2 else b"") for frame in sent)
    decoder, found, at = Decoder(signing=side()), [], 0
    while at < len(data):
        step = rng.randrange(1, 60)
        found += [frame.raw for frame in decoder.piece(data[at : at + step], 1e-4 * at)]
        at += step
    assert found == sent
    assert pymavlink_frame(HEARTBEAT, random_values(HEARTBEAT, rng, 0.3), 0)[2] == 0
