"""A flight to be: where it begins, what happens to it and when, and how it must end."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.phases import Phase
from companion.vehicle import OutputLevel
from companion.world import Link
from companion.world.events import Event, Operator, Order, When

LEVELS = (OutputLevel.RATES, OutputLevel.ATTITUDE, OutputLevel.MOTORS)
BEFORE_FLIGHT = LEVELS[:1]
"""Where a flight is refused by rules in which the level has no say."""


class Begin(enum.Enum):
    """Where the vehicle is at the start. ``ON_THE_PATH``: in a hover on it; ``BESIDE``: in a hover 8 m away and 5 m
    higher, so that joining takes a while; ``ON_THE_GROUND``: standing at the origin, switched on just now."""

    ON_THE_PATH = "on the path"
    BESIDE = "beside the path"
    ON_THE_GROUND = "on the ground"


class End(enum.Enum):
    """How a flight must end.

    ``FLOWN``: as if nothing had happened. ``HELD``: given up with a reason, and the vehicle holds. ``REFUSED``: not
    begun: nothing armed, no mode asked for. ``OPERATORS``: over, and the vehicle does what its operator said last.
    ``FAILSAFE``: over, and what PX4 does about lost setpoints decides. ``ENDED``: over with a reason; the vehicle cannot
    be held, or was already on the ground. ``DISARMED``: over with a reason, and the vehicle is disarmed.
    """

    FLOWN = "flown"
    HELD = "held"
    REFUSED = "refused"
    OPERATORS = "the operator's"
    FAILSAFE = "PX4's failsafe"
    ENDED = "ended"
    DISARMED = "disarmed"


@dataclass(frozen=True)
class Strike:
    """Events that begin to count when the companion enters a phase for the first time."""

    phase: Phase
    events: tuple[Event, ...]


@dataclass(frozen=True)
class Case:
    """``events``: what happens; their times count from when ``phase`` begins, or from the plant's start where that is
    None. ``strikes``: the same again, each with a phase of its own. ``mutated``: the share of the vehicle's messages in
    which one field says something else, its checksum right. ``end``: how it must end, ``or_end``: how it may end too; ``says``: a pattern of the sentence that is said then.
    ``parameters``: PX4's, set before. ``within``: s after the first event in which it must be given up; None: any.
    ``loses_thrust``: it may come down. ``tilt_max``: degrees, at most, while it is ours. ``lost_max``: m of height at
    most; None: half of it. ``stop_at``: when the user stops it (s, as the events). ``watched_for``: s for which the
    vehicle is watched on. ``time_out``: s of the plant within which it must be over.
    """

    name: str
    end: End
    says: str = ""
    or_end: tuple[End, ...] = ()
    events: tuple[Event, ...] = ()
    phase: Phase | None = None
    strikes: tuple[Strike, ...] = ()
    mutated: float = 0.0
    link: Link = field(default_factory=Link)
    begin: Begin = Begin.ON_THE_PATH
    levels: tuple[OutputLevel, ...] = LEVELS
    duration: float = 6.0
    authority: ControlAuthority = ControlAuthority.COMPANION
    finish: Finish = Finish.AS_BEGUN
    parameters: Mapping[str, float] = field(default_factory=dict)
    within: float | None = None
    loses_thrust: bool = False
    tilt_max: float = 50.0
    lost_max: float | None = None
    stop_at: float | None = None
    mission: str = "circle_r5"
    speed: float = 3.0
    watched_for: float = 2.0
    time_out: float = 90.0


def shifted(event: Event, t: float) -> Event:
    """The event ``t`` s later, counted from the plant's start."""
    begin, end, _ = event.when
    return replace(event, when=When(t + begin, t + end if math.isfinite(end) else end))


def at(t: float, order: Order) -> Operator:
    """The operator's order at a time, s."""
    return Operator(When(t, t), order)
