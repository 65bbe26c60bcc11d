"""Whole messages with any values in their fields, from the vehicle itself and from others on its link: none raises."""

from __future__ import annotations

import math
import random
import struct

import pytest

from companion.mavlink.codec import Encoder
from companion.mavlink.dialect import FORMATS, Format, Value
from companion.vehicle import OutputLevel
from sim_bridge.world_events import COMPANION
from tests.support.flights import Flown, flight

EXTREMES = {
    "f": (0.0, math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, 1.0),
    "d": (0.0, math.nan, math.inf, 1e308),
}


def any_values(fmt: Format, rng: random.Random) -> tuple[Value, ...]:
    """Extremes of every type, or random bits."""
    flat: list[Value] = []
    for code, zero in zip(fmt.codes, fmt.zero, strict=True):
        if code == "s":
            flat.append(rng.randbytes(len(zero)))
        elif code == "c":
            flat.append(rng.randbytes(1))
        elif rng.random() < 0.4:
            flat.append(struct.unpack(f"<{code}", rng.randbytes(struct.calcsize(code)))[0])
        elif code in EXTREMES:
            flat.append(rng.choice(EXTREMES[code]))
        else:
            bits = 8 * struct.calcsize(code)
            low, high = (0, 2**bits - 1) if code.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
            flat.append(rng.choice((low, high, 0, 1, high // 2)))
    return tuple(flat)


@pytest.mark.parametrize("level", [OutputLevel.MOTORS, OutputLevel.RATES])
@pytest.mark.parametrize("seed", range(3))
def test_no_message_whatever_its_values_raises(level: OutputLevel, seed: int) -> None:
    rng = random.Random(seed)
    heard = [FORMATS[msgid] for msgid in sorted(FORMATS) if msgid != 0 or seed]
    senders = [Encoder(1, 1), Encoder(1, 1), Encoder(255, 190), Encoder(1, 191), Encoder(7, 1)]
    wanted: list[Format] = []
    sent = [0]

    def speak(flown: Flown, now: float) -> None:
        wanted[:] = wanted or [FORMATS[msgid] for msgid in sorted(flown.conductor.decoder.wanted or ())]
        if seed and flown.conductor.memory is None:
            return  # a flight that has begun
        for _ in range(3):
            fmt = rng.choice(wanted if rng.random() < 0.8 else heard)
            data = rng.choice(senders).encode(fmt, any_values(fmt, rng))
            flown.conductor.receive([(data, rng.choice((COMPANION, COMPANION, 7)))], now)
            sent[0] += 1

    flown = flight(level=level, duration=3.0, meddle=speak, time_out=8.0)
    while sent[0] < 1000:  # whatever it was that ended the flight
        now = flown.between.now + 0.004 * sent[0]
        speak(flown, now)
        flown.conductor.on_timer(now)
        flown.conductor.datagrams()
        flown.conductor.finish_tick()
    for line in flown.notes + flown.conductor.link.peers.words():
        assert line.isprintable(), line
    for name, value in ((name, getattr(flown.conductor.telemetry, name)) for name in ("home", "origin")):
        assert value is None or all(map(math.isfinite, value[:3])), name
