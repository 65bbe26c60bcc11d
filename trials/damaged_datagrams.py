"""Datagrams damaged at random: the codec must raise nothing and miss no intact frame among them."""

from __future__ import annotations

import random

from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import FORMATS, Format, Value


def random_values(fmt: Format, rng: random.Random, zeros: float) -> tuple[Value, ...]:
    """Values drawn as random payload bytes, a share of them zero so that truncation happens."""
    payload = bytes(0 if rng.random() < zeros else rng.randrange(256) for _ in range(fmt.size))
    return fmt.unpack(payload)


def mutated(frame: bytes, rng: random.Random) -> bytes:
    data = bytearray(frame)
    for _ in range(rng.randrange(1, 4)):
        kind = rng.randrange(4)
        at = rng.randrange(len(data)) if data else 0
        if kind == 0 and data:
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1 and data:
            del data[at : at + rng.randrange(1, 5)]
        elif kind == 2:
            data[at:at] = bytes(rng.choices((0xFD, 0xFE, 0, 255, 40), k=rng.randrange(1, 5)))
        else:
            data[at:] = b""
    return bytes(data)


def fuzz(count: int, seed: int) -> int:
    """Feed ``count`` datagrams, most of them damaged; the number of intact frames that were not decoded."""
    rng = random.Random(seed)
    formats = list(FORMATS.values())
    encoder = Encoder(1, 1)
    pool = [encoder.encode(f, random_values(f, rng, 0.4)) for f in rng.choices(formats, k=2000)]
    decoder = Decoder()
    missed = 0
    for _ in range(count):
        parts = []
        intact = []
        for _ in range(rng.randrange(1, 3)):
            frame = pool[rng.randrange(len(pool))]
            if rng.random() < 0.6:
                frame = mutated(frame, rng)
            else:
                intact.append(frame)
            parts.append(frame)
        found = {f.raw for f in decoder.datagram(b"".join(parts))}
        missed += sum(frame not in found for frame in intact)
    return missed
