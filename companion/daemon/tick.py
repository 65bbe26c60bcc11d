"""A tick between its two halves: the setpoint first, the rest after the send."""

from __future__ import annotations

from typing import NamedTuple

from companion.pilot import First, Memory, Observation, Outcome


class Tick(NamedTuple):
    """What the last tick saw and did, kept until the setpoint is on its way; and what it remembered ``before``."""

    seen: Observation
    memory: Memory
    outcome: Outcome
    now: float
    before: Memory


class Half(NamedTuple):
    """A tick whose setpoint is queued already, and whose rest comes after the send."""

    seen: Observation
    early: First | None
    now: float
    before: Memory
