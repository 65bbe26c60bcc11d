"""What happens in a world at a time: pushes, holds, failures, resets, cuts.

A time is counted from the plant's start, or from the first setpoint that is flown in OFFBOARD.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple

from companion.frames import Vec3


class When(NamedTuple):
    """From ``begin`` until ``end``, s; what happens once happens at ``begin``.

    ``after_offboard``: counted from the first setpoint flown in OFFBOARD, not from the plant's start.
    """

    begin: float
    end: float = math.inf
    after_offboard: bool = False


@dataclass(frozen=True, slots=True)
class Push:
    """A force on the centre of mass, N in NED."""

    when: When
    force_n: Vec3


@dataclass(frozen=True, slots=True)
class Hold:
    """Somebody holds the vehicle: position and attitude stand still, velocity and rates are zero; then lets go."""

    when: When


@dataclass(frozen=True, slots=True)
class Wind:
    """Another mean wind while it lasts, m/s in NED."""

    when: When
    wind_n: Vec3


@dataclass(frozen=True, slots=True)
class MotorFailure:
    """A motor (1..4, the autopilot's order) gives only ``left`` of its thrust."""

    when: When
    motor: int
    left: float = 0.0


@dataclass(frozen=True, slots=True)
class EstimatorReset:
    """The estimate jumps, once and for good, and its reset counter counts: m, m/s in NED; rad about down."""

    when: When
    position_n: Vec3 = (0.0, 0.0, 0.0)
    velocity_n: Vec3 = (0.0, 0.0, 0.0)
    yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class ClockJump:
    """The stamps the vehicle sends jump by ``by`` s, once and for good."""

    when: When
    by: float


class Part(enum.Enum):
    """A part of the state the vehicle sends."""

    POSITION = "position"
    ATTITUDE = "attitude"
    STATE = "state"


@dataclass(frozen=True, slots=True)
class NotANumber:
    """What the vehicle sends of its state is NaN."""

    when: When
    part: Part = Part.STATE


@dataclass(frozen=True, slots=True)
class Silence:
    """The vehicle sends nothing of a part of its state; everything else goes on."""

    when: When
    part: Part = Part.STATE


@dataclass(frozen=True, slots=True)
class LinkCut:
    """Nothing comes through, each way by itself. ``companion``, ``ground_station``: whose link."""

    when: When
    down: bool = True
    up: bool = True
    companion: bool = True
    ground_station: bool = False


Happening = Push | Hold | Wind | MotorFailure | NotANumber | Silence | LinkCut
"""What lasts."""
Jump = EstimatorReset | ClockJump
"""What happens once."""
Event = Happening | Jump
