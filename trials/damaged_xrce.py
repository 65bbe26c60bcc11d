"""XRCE datagrams of a real session, spoilt as links and strangers spoil them, the same for the same seed."""

from __future__ import annotations

import random
from collections.abc import Sequence

from companion.xrce.agent import Agent
from companion.xrce.messages import BEST_EFFORT
from companion.xrce.topics import LAYOUTS

SESSION_LASTS = 1000
"""Datagrams that one agent takes."""


def spoil(rng: random.Random, data: bytes) -> bytes:
    """One datagram after something happened to it."""
    spoilt = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        if not spoilt:
            break
        at = rng.randrange(len(spoilt))
        match rng.randrange(6):
            case 0:
                spoilt[at] ^= 1 << rng.randrange(8)
            case 1:
                spoilt[at] = rng.choice((0, 1, 0x7F, 0x80, 0xFF))
            case 2:
                del spoilt[at:]
            case 3:
                spoilt[at:at] = rng.randbytes(rng.randint(1, 8))
            case 4:
                spoilt[at : at + 4] = rng.choice((b"\xff" * 4, b"\0" * 4, b"\0\0\0\x80"))
            case 5:
                spoilt += spoilt[at:]
    return bytes(spoilt)


def fuzz(datagrams: Sequence[bytes], count: int, seed: int) -> int:
    """Have agents whose session stands take ``count`` datagrams of a client in any order, two in three of them spoilt.
    How many samples were read; what is raised is a fault. ``datagrams``: a client's whole session."""
    rng = random.Random(seed)
    samples = 0
    for begin in range(0, count, SESSION_LASTS):
        agent = Agent()
        for data in datagrams:
            agent.receive(data, 0.0)
            agent.datagrams(0.0)
        for index in range(begin, min(begin + SESSION_LASTS, count)):
            data = _numbered(rng.choice(datagrams), index % SESSION_LASTS + len(datagrams))
            for sample in agent.receive(data if index % 3 == 0 else spoil(rng, data), index * 1e-3):
                layout = LAYOUTS.get(sample.topic[:2])
                samples += layout is not None and layout.decode(sample.cdr) is not None
            agent.write([("actuator_motors", bytes(68))])
            agent.datagrams(index * 1e-3)
            agent.next_timer()
    return samples


def _numbered(data: bytes, number: int) -> bytes:
    """A best-effort message as the next one, else as it is."""
    return data[:2] + number.to_bytes(2, "little") + data[4:] if data[1] == BEST_EFFORT else data
