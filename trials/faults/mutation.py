"""Messages in which one field says something else: whole frames with a right checksum, which no decoder can refuse."""

from __future__ import annotations

import math
import random

from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import Value
from companion.mavlink.link import WANTED as LINK_WANTED
from companion.mavlink.telemetry import WANTED

READ = frozenset(WANTED | LINK_WANTED)
"""The messages that the companion reads."""
FLOATS = (0.0, -0.0, 1.0, -1.0, 1e-30, 1e9, -1e9, 3e38, math.nan, math.inf, -math.inf)
SEQUENCE_AT = 4
"""Where a MAVLink 2 frame has its sequence number."""


class Mutator:
    """Changes a share of the datagrams, the same ones for the same seed. ``changed``: how many so far."""

    def __init__(self, share: float, seed: int) -> None:
        self._share = share
        self._random = random.Random(f"mutation {seed}")
        self._decoder = Decoder(wanted=READ)
        self.changed = 0

    def __call__(self, datagram: bytes) -> bytes:
        rng = self._random
        if rng.random() >= self._share:
            return datagram
        frames = self._decoder.datagram(datagram)
        if len(frames) != 1 or frames[0].raw != datagram:
            return datagram
        frame = frames[0]
        values = list(frame.values)
        at = rng.randrange(len(values))
        values[at] = self._other(values[at])
        encoder = Encoder(frame.system, frame.component, datagram[SEQUENCE_AT])
        try:
            changed = encoder.encode(frame.format, tuple(values))
        except Exception:
            return datagram
        self.changed += 1
        return changed

    def _other(self, value: Value) -> Value:
        rng = self._random
        if isinstance(value, float):
            return rng.choice((*FLOATS, value * rng.uniform(-3.0, 3.0), value + rng.gauss(0.0, 1.0)))
        if isinstance(value, int):
            return rng.choice((0, 1, value ^ 1 << rng.randrange(8), value + 1, 255, 65535, 2**32 - 1, 2**64 - 1))
        if isinstance(value, bytes):
            return bytes(rng.randrange(256) for _ in value)
        return value
