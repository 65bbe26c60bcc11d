"""A peer whose datagrams are pieces of a byte stream, and input that is made to cost time."""

from __future__ import annotations

import random
import time

import pytest

from companion.mavlink.codec import DATAGRAM_MAX, UNFINISHED_MAX, Decoder, Encoder
from companion.mavlink.dialect import BY_NAME
from tests.mavlink.test_codec import random_values

NAMES = ("ODOMETRY", "HEARTBEAT", "ATTITUDE_QUATERNION", "STATUSTEXT", "CURRENT_MODE")
ODOMETRY, HEARTBEAT = BY_NAME["ODOMETRY"], BY_NAME["HEARTBEAT"]


def sent_frames(count: int, rng: random.Random) -> list[bytes]:
    encoder = Encoder(1, 1)
    return [encoder.encode(f, random_values(f, rng, 0.3)) for f in (BY_NAME[rng.choice(NAMES)] for _ in range(count))]


@pytest.mark.parametrize("longest", [7, 60, 400, 1400])
def test_bytes_cut_anywhere_into_datagrams_give_every_frame(longest: int) -> None:
    rng = random.Random(longest)
    sent = sent_frames(500, rng)
    data = b"".join(sent)
    decoder, found, at, now = Decoder(), [], 0, 0.0
    while at < len(data):
        step = rng.randrange(1, longest)
        found += [frame.raw for frame in decoder.piece(data[at : at + step], now)]
        at += step
        now += 2e-4 * longest**0.5
    assert found == sent
    assert decoder.counters.garbage_bytes == decoder.counters.bad_crc == decoder.counters.lost == 0


def test_lost_pieces_cost_only_the_frames_they_held() -> None:
    rng = random.Random(3)
    sent = sent_frames(600, rng)
    data = b"".join(sent)
    ends = [0]
    for frame in sent:
        ends.append(ends[-1] + len(frame))
    decoder, found, at = Decoder(), [], 0
    gone: list[tuple[int, int]] = []
    while at < len(data):
        step = rng.randrange(1, 200)
        if rng.random() < 0.1:
            gone.append((at, at + step))
        else:
            found += [frame.raw for frame in decoder.piece(data[at : at + step], 1e-5 * at)]
        at += step
    whole = [f for f, a, b in zip(sent, ends, ends[1:], strict=False) if not any(a < y and x < b for x, y in gone)]
    assert found == whole


def test_a_whole_frame_at_a_datagrams_start_is_believed_before_any_completion() -> None:
    encoder = Encoder(1, 1)
    first, second = (encoder.message(ODOMETRY, time_usec=i, q=(1.0, 0.0, 0.0, 0.0)) for i in (1, 2))
    decoder = Decoder()
    assert decoder.piece(first[:-5], 0.0) == []
    assert [f.raw for f in decoder.piece(second, 0.01)] == [second]
    assert decoder.piece(first[:-5], 0.02) == []
    assert [f.raw for f in decoder.piece(second + first[:30], 0.03)] == [second]  # and its own rest is kept
    assert [f.raw for f in decoder.piece(first[30:], 0.04)] == [first]
    assert decoder.counters.garbage_bytes == 2 * (len(first) - 5)


def test_the_beginning_of_a_frame_is_kept_for_a_tenth_of_a_second() -> None:
    frame = Encoder(1, 1).message(ODOMETRY, time_usec=1, q=(1.0, 0.0, 0.0, 0.0), quality=9)
    decoder = Decoder()
    decoder.piece(frame[:40], 1.0)
    decoder.piece(frame[40:80], 1.0 + 0.9 * UNFINISHED_MAX)  # its first byte counts, not its last
    assert decoder.piece(frame[80:], 1.0 + 1.1 * UNFINISHED_MAX) == []
    decoder.piece(frame[:40], 2.0)
    assert [f.raw for f in decoder.piece(frame[40:], 2.0 + 0.9 * UNFINISHED_MAX)] == [frame]


@pytest.mark.parametrize("flags", range(2, 256, 7))
def test_flags_that_we_do_not_know_are_never_a_frame(flags: int) -> None:
    frame = Encoder(1, 1).message(HEARTBEAT, type=2)
    for strange in (frame[:2] + bytes([flags]) + frame[3:end] for end in range(3, len(frame) + 1)):
        decoder = Decoder()
        assert decoder.piece(strange, 0.0) == []
        assert [f.raw for f in decoder.piece(frame, 0.01)] == [frame]
        assert decoder.datagram(strange) == []


FLOODS = {
    "0xFE": b"\xfe",
    "0xFD": b"\xfd",
    "MAVLink 1 of a known message": b"\xfe\x09\xfe\xfe\xfe",
    "MAVLink 2 of a known message": b"\xfd\xff\x00\x01\x00",
    "MAVLink 2 of an unknown message": b"\xfd\x10\x00\x00",
}


@pytest.mark.parametrize("flood", FLOODS.values(), ids=FLOODS)
def test_no_datagram_costs_more_than_a_few_milliseconds(flood: bytes) -> None:
    """65507 bytes of 0xFE took 331 ms once. Measured here: 1.7 ms at most; the limit leaves room for a busy machine."""
    data = (flood * 65507)[:65507]
    took = []
    for _ in range(5):
        decoder = Decoder()
        begun = time.perf_counter()
        decoder.piece(data, 0.0)
        took.append(time.perf_counter() - begun)
        assert decoder.counters.garbage_bytes + 28 * decoder.counters.unknown + 300 >= len(data)
    assert min(took) < 0.008


@pytest.mark.parametrize("flood", FLOODS.values(), ids=FLOODS)
def test_a_flood_hides_neither_the_frame_before_it_nor_the_next_datagram(flood: bytes) -> None:
    frame = Encoder(1, 1).message(HEARTBEAT, type=2, autopilot=12)
    decoder = Decoder()
    assert frame in [f.raw for f in decoder.piece(frame + flood * 3000, 0.0)]
    assert [f.raw for f in decoder.piece(frame, 0.01)] == [frame]


def test_of_a_datagram_larger_than_any_router_sends_only_the_beginning_is_looked_at() -> None:
    frame = Encoder(1, 1).message(ODOMETRY, q=(1.0, 0.0, 0.0, 0.0))
    decoder = Decoder()
    frames = decoder.datagram(frame * (65507 // len(frame)))
    assert len(frames) == DATAGRAM_MAX // len(frame)
    assert decoder.counters.frames * len(frame) + decoder.counters.garbage_bytes == 65507 // len(frame) * len(frame)
