"""A session of PX4 main of March 2026 (SITL, UDP) with an agent, as captured: who said what."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

FILE = Path(__file__).parents[1] / "data" / "xrce_session.hex"


class Captured(NamedTuple):
    """A datagram: when (s) it went, whether from PX4's client, and its bytes."""

    at: float
    of_client: bool
    data: bytes


def session() -> list[Captured]:
    """All of it."""
    lines = (line.split() for line in FILE.read_text(encoding="ascii").splitlines())
    return [Captured(float(at), way == "<", bytes.fromhex(data)) for at, way, data in lines]
