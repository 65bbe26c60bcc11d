"""XRCE on a serial line."""

from __future__ import annotations

import random

from companion.xrce.framing import AGENT, CLIENT, Deframer, framed
from tests.xrce.captured import session

INFO = bytes.fromhex("8000000006011000000afffd000000010d00010000000000")


def test_a_frame_is_the_bytes_that_px4_has_taken() -> None:
    assert framed(INFO, AGENT, CLIENT) == bytes.fromhex("7e00011800") + INFO + bytes.fromhex("3d2d")
    assert framed(b"\x7e\x7d", AGENT, CLIENT)[:9].hex() == "7e000102007d5e7d5d"


def test_messages_come_out_of_pieces_as_they_went_in() -> None:
    rng = random.Random(1)
    sent = [each.data for each in session() if each.of_client] + [b"\x7e\x7d\x7e" * 20]
    line = b"noise" + b"".join(framed(data, CLIENT, AGENT) for data in sent)
    deframer, read = Deframer(AGENT), []
    while line:
        size = rng.randint(1, 60)
        read += deframer.receive(line[:size])
        line = line[size:]
    assert read == sent


def test_what_is_spoilt_costs_itself_alone() -> None:
    good = framed(INFO, CLIENT, AGENT)
    spoilt = good[:9] + b"\x55" + good[10:]
    deframer = Deframer(AGENT)
    assert deframer.receive(good[:11] + good + spoilt + framed(INFO, AGENT, CLIENT) + good) == [INFO, INFO]
    assert deframer.counters.garbage == 3  # one cut short, one spoilt, one for the client


def test_noise_is_no_message_and_is_not_kept() -> None:
    rng = random.Random(2)
    deframer = Deframer(AGENT)
    for _ in range(2000):
        assert deframer.receive(rng.randbytes(50)) == []
    assert deframer.receive(b"\x7e") == []
    assert deframer.receive(framed(INFO, CLIENT, AGENT)) == [INFO]
