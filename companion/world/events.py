"""What happens in a world at a time: to the machine, to its estimate, to what it says, to its links; and who acts.

    events        pushes, holds, failures, resets; what the vehicle says wrongly of its state
    link_events   what becomes of datagrams while it lasts
    actors        the operator, the pilot's sticks, strangers on the link

A time is counted from the plant's start, from the first arming, or from the first setpoint that is flown in OFFBOARD.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from companion.frames import Vec3
from companion.world.actors import Operator, Order, PortChange, Saying, Sticks, Stranger
from companion.world.link_events import (
    LinkCut,
    LinkDelay,
    LinkDuplicate,
    LinkEvent,
    LinkRecut,
    LinkRepeat,
    LinkThin,
)
from companion.world.when import After, When

__all__ = [
    "After", "ClockJump", "EstimatorReset", "Event", "FrozenState", "Hold", "Impostor", "Jump", "LastingEvent",
    "LinkCut", "LinkDelay", "LinkDuplicate", "LinkEvent", "LinkRecut", "LinkRepeat", "LinkThin", "MotorFailure",
    "NotANumber", "OdometryFrames", "OffsetState", "Operator", "Order", "Part", "PayloadDrop", "PortChange",
    "Push", "Saying", "Silence", "Stamps", "StateFault", "Sticks", "Stranger", "When", "Wind", "WrongStamps",
]  # fmt: skip


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
    """A motor (1..4, the autopilot's order; None: every one) gives only ``left`` of its thrust."""

    when: When
    motor: int | None
    left: float = 0.0


@dataclass(frozen=True, slots=True)
class PayloadDrop:
    """What hung below the centre of mass falls off: the vehicle is lighter by ``mass`` kg, its moments of inertia and
    the force of its drag stay."""

    when: When
    mass: float


@dataclass(frozen=True, slots=True)
class EstimatorReset:
    """The estimate jumps, once and for good: m, m/s in NED; rad about down. ``counted``: by its reset counter."""

    when: When
    position_n: Vec3 = (0.0, 0.0, 0.0)
    velocity_n: Vec3 = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    counted: bool = True


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
    """What the vehicle sends of its state is ``value``: NaN, infinite, or a number no vehicle has."""

    when: When
    part: Part = Part.STATE
    value: float = math.nan


@dataclass(frozen=True, slots=True)
class Silence:
    """The vehicle sends nothing of a part of its state; everything else goes on."""

    when: When
    part: Part = Part.STATE


@dataclass(frozen=True, slots=True)
class FrozenState:
    """What the vehicle sends of a part of its state stays as it was, but for white noise of ``noise`` (m; 1 of a
    quaternion): position without velocity, attitude without rates."""

    when: When
    part: Part = Part.POSITION
    noise: float = 0.0


@dataclass(frozen=True, slots=True)
class OffsetState:
    """What the vehicle sends of its state is off by so much, and no reset counter counts: m, m/s in NED; rad."""

    when: When
    position_n: Vec3 = (0.0, 0.0, 0.0)
    velocity_n: Vec3 = (0.0, 0.0, 0.0)
    yaw: float = 0.0


class Stamps(enum.Enum):
    """What the vehicle's stamps of its state are instead of what they should be."""

    ZERO = "zero"
    FROZEN = "frozen"
    MILLISECONDS = "milliseconds"
    HUGE = "huge"


@dataclass(frozen=True, slots=True)
class WrongStamps:
    """The stamps of the state the vehicle sends are wrong: always zero, always the same, in ms instead of us, or the
    largest number there is."""

    when: When
    stamps: Stamps = Stamps.ZERO


@dataclass(frozen=True, slots=True)
class OdometryFrames:
    """ODOMETRY comes in other frames (MAV_FRAME): of the pose, and of the velocity."""

    when: When
    pose: int = 1
    velocity: int = 1


@dataclass(frozen=True, slots=True)
class Impostor:
    """The vehicle's heartbeats tell another MAV_TYPE and MAV_AUTOPILOT than a PX4 quadrotor's."""

    when: When
    type: int = 2
    autopilot: int = 12


StateFault = NotANumber | Silence | FrozenState | OffsetState | WrongStamps | OdometryFrames | Impostor
"""What the vehicle says wrongly, or not at all, of itself and its state."""
LastingEvent = Push | Hold | Wind | MotorFailure | StateFault | LinkEvent | Sticks | Stranger
"""What lasts."""
Jump = PayloadDrop | EstimatorReset | ClockJump | Operator | PortChange
"""What happens once."""
Event = LastingEvent | Jump
