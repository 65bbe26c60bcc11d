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
    """What the guards look at."""

    phase: Phase
    now: float  # s, our clock
    entered: float  # s, since when the phase lasts
    status: KnownStatus  # what is known of the vehicle
    mode_seen: bool  # the mode of this phase was seen in telemetry
    state_at: float | None  # s, when the last state was measured
    answer: Answer | None  # the last one to this phase's request
    from_ground: bool  # the flight began on the ground
    authority: ControlAuthority = ControlAuthority.COMPANION
    finish: Finish = Finish.AS_BEGUN
    faulty: bool = False  # something went wrong before
    stop: bool = False  # told to stop
    missing: str | None = None  # what the preflight lacks
    settled: bool = False  # the thrust is known
    joined: bool = False  # the path is reached
    at_end: bool = False  # its open end is
    goes_back: bool = False  # the path is flown back from its end
    finished: str | None = None  # why following is over; None: it is not
    law_error: str | None = None  # why the law has no answer; None: it has
    verdict: Verdict = NO_FAULT  # of the safety rows
    decided_in: Mode | None = None  # the mode in which the phase began to ask
    asked: int = 1  # how often it has
    asked_at: float = math.inf  # s, when last
    unusable: str | None = None  # what came in the place of a state
    late: float = 0.0  # s that the last state came late
    answered: float = 0.0  # s since what is asked for was answered, or first seen where no answer had accepted it
    armed_heard: float = math.inf  # s since armed was last said
    flown_in: str = "OFFBOARD"  # what the pilot's ground station calls the mode that flies on our setpoints
