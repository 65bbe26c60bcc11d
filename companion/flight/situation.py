"""What the guards look at, as one value."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.phases import Phase, Request
from companion.flight.safety import NO_FAULT, Verdict
from companion.mavlink_common import MavResult
from companion.vehicle import KnownStatus, Mode


class Answer(NamedTuple):
    """The vehicle's answer to a request."""

    request: Request
    reply: MavResult

    @property
    def accepted(self) -> bool:
        """Whether the vehicle does it, or is about to."""
        return self.reply in (MavResult.ACCEPTED, MavResult.IN_PROGRESS)


class Situation(NamedTuple):
    """What the guards look at.

    ``now``, ``entered``: s, our clock, and since when the phase lasts. ``status``: what is known of the vehicle.
    ``mode_seen``: the mode of this phase was seen in telemetry. ``decided_in``: the mode in which the phase began to
    ask, ``asked``: how often it has, ``asked_at`` s when last. ``state_at``: when the last state was measured;
    ``unusable``: what came in its place; ``late``: s that it came late.
    ``answer``: the last answer to this phase's request, ``answered``: s since it came, and ``armed_heard``: s since
    armed was last said. ``from_ground``: the flight began on the ground.
    ``faulty``: something went wrong before. ``stop``: told to stop. ``missing``: what the preflight lacks.
    ``settled``, ``joined``, ``at_end``: the thrust is known, the path is reached, its open end is. ``goes_back``: the
    path is flown back from its end. ``finished``, ``law_error``: reasons, or None. ``verdict``: of the safety rows.
    """

    phase: Phase
    now: float
    entered: float
    status: KnownStatus
    mode_seen: bool
    state_at: float | None
    answer: Answer | None
    from_ground: bool
    authority: ControlAuthority = ControlAuthority.COMPANION
    finish: Finish = Finish.AS_BEGUN
    faulty: bool = False
    stop: bool = False
    missing: str | None = None
    settled: bool = False
    joined: bool = False
    at_end: bool = False
    goes_back: bool = False
    finished: str | None = None
    law_error: str | None = None
    verdict: Verdict = NO_FAULT
    decided_in: Mode | None = None
    asked: int = 1
    asked_at: float = math.inf
    unusable: str | None = None
    late: float = 0.0
    answered: float = 0.0
    armed_heard: float = math.inf
