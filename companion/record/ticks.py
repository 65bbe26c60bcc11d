"""The ticks and the true states of a flight in memory: for its figures, where nobody asked for a folder."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from companion.pilot import Memory, Observation, Outcome
from companion.plan import Plan
from companion.record import rows
from companion.record.table import RowPacker, Table
from companion.record.tick_columns import COLUMNS


class TickRecorder(Protocol):
    """What a conductor tells of a flight; see ``folder.Recorder``."""

    def add_frame(self, now: float, raw: bytes) -> None:
        """One frame, either direction."""

    def add_datagram(self, now: float, to_px4: bool, data: bytes) -> None:
        """One datagram of PX4's XRCE client, or one to it."""

    def begin(self, plan: Plan, now: float) -> None:
        """The plan is ready and the pilot begins."""

    def add_settings(self, changed: dict[str, float], now: float) -> None:
        """Gains or limits were set from outside."""

    def add_tick(self, seen: Observation, memory: Memory, outcome: Outcome, now: float, latency: float) -> None:
        """One tick of the pilot."""


class Ticks:
    """Keeps what the summary is made of, and no frame. ``table``: as that of a flight folder."""

    _packer = RowPacker(COLUMNS)

    def __init__(self) -> None:
        self._rows: list[bytes] = []

    def add_frame(self, now: float, raw: bytes) -> None:
        """Nothing is kept."""

    def add_datagram(self, now: float, to_px4: bool, data: bytes) -> None:
        """See TickRecorder: not kept."""

    def begin(self, plan: Plan, now: float) -> None:
        """Nothing is kept."""

    def add_settings(self, changed: dict[str, float], now: float) -> None:
        """Nothing is kept."""

    def add_tick(self, seen: Observation, memory: Memory, outcome: Outcome, now: float, latency: float) -> None:
        """One tick of the pilot."""
        self._rows.append(self._packer.pack(rows.row(seen, memory, outcome, now, latency)))

    @property
    def table(self) -> Table:
        """Every tick so far."""
        return np.frombuffer(b"".join(self._rows), self._packer.dtype)
