"""``link.tlog``: every frame in both directions, as QGroundControl, MAVProxy and pymavlink read it.

Each record is the time as a big-endian count of microseconds since 1970 and the raw frame.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

from companion.mavlink.codec import Decoder
from companion.record.growing import GrowingFile

FRAMES_WAITING = 30_000
"""Frames that wait for the disk at most, about half a minute of a 250 Hz link in 6 MB (engineering choice)."""
_STAMP = struct.Struct(">Q")


class TlogWriter(GrowingFile):
    """Writes frames. ``epoch``: s since 1970 at which our monotonic clock read zero."""

    def __init__(self, path: Path, epoch: float) -> None:
        super().__init__(path, FRAMES_WAITING)
        self._epoch = epoch

    def add_frame(self, now: float, raw: bytes) -> None:
        """Take one frame that came or went at ``now``."""
        self.append(_STAMP.pack(round((self._epoch + now) * 1e6)) + raw)


def records(data: bytes) -> Iterator[tuple[float, bytes]]:
    """(s since 1970, raw frame) of a tlog's bytes. What is not a record is skipped to the next one that is."""
    at = 0
    decoder = Decoder(wanted=())
    while at + 8 + 8 <= len(data):
        (stamp,) = _STAMP.unpack_from(data, at)
        start = at + 8
        if data[start] == 0xFD and len(data) >= start + 12:
            end = start + 12 + data[start + 1] + (13 if data[start + 2] & 1 else 0)
        elif data[start] == 0xFE:
            end = start + 8 + data[start + 1]
        else:
            end = 0
        if end == 0 or end > len(data):
            at += 1
            continue
        raw = data[start:end]
        before = decoder.counters.frames + decoder.counters.unknown
        decoder.datagram(raw)
        if decoder.counters.frames + decoder.counters.unknown == before:
            at += 1
            continue
        yield stamp * 1e-6, raw
        at = end
