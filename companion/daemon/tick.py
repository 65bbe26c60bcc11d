"""A tick between its two halves: the setpoint first, the rest after the send."""

from __future__ import annotations

from typing import NamedTuple

from companion.pilot import LawOutput, Memory, Observation, Outcome


class Tick(NamedTuple):
    """What the last tick saw and did, kept until the setpoint is on its way; and what it remembered ``before``."""

    observation: Observation
    memory: Memory
    outcome: Outcome
    now: float
    before: Memory


class UnfinishedTick(NamedTuple):
    """A tick whose setpoint is queued, if it has one ``early``; ``pilot.supervise`` comes after the send."""

    observation: Observation
    early: LawOutput | None
    now: float
    before: Memory
