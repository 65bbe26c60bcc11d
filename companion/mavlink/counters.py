"""What a decoder has seen, in numbers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Counters:
    """What a decoder has seen. ``lost``: frames missing by their senders' sequence numbers."""

    frames: int = 0
    unknown: int = 0
    bad_crc: int = 0
    garbage_bytes: int = 0
    lost: int = 0
