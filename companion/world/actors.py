"""Who acts in a world beside vehicle and companion: the operator, the pilot's hands, strangers on the link."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from companion.frames import Vec3
from companion.world.when import When


class Order(enum.Enum):
    """What an operator asks the vehicle for, from his ground station."""

    HOLD = "hold"
    LAND = "land"
    RETURN = "return"
    POSITION = "position"
    ALTITUDE = "altitude"
    STABILIZED = "stabilized"
    MISSION = "mission"
    OFFBOARD = "offboard"
    TAKE_OFF = "take_off"
    ARM = "arm"
    DISARM = "disarm"
    KILL = "kill"
    TERMINATE = "terminate"


@dataclass(frozen=True, slots=True)
class Operator:
    """The operator asks for something, once, over a link of his own. ``KILL``: a disarming by force, in the air too;
    a mode for which the sticks are needed is refused without them, as by PX4."""

    when: When
    order: Order


@dataclass(frozen=True, slots=True)
class Sticks:
    """The pilot has the sticks in his hands: -1..1, roll right, pitch forward, yaw right, throttle up positive."""

    when: When
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    throttle: float = 0.0


class Saying(enum.Enum):
    """What a stranger says."""

    HEARTBEAT = "heartbeat"
    MODE = "mode"
    STATE = "state"


@dataclass(frozen=True, slots=True)
class Stranger:
    """Somebody else speaks to the companion: a second vehicle, a copy of ours, another companion.

    ``system``, ``component``, ``type`` (MAV_TYPE), ``autopilot`` (MAV_AUTOPILOT): who it says it is. ``says``: a
    heartbeat once a second, CURRENT_MODE ten times, ODOMETRY fifty times. ``mode`` is what it flies, ``armed`` whether
    it does, standing still at ``position_n`` (m). ``own_port``: it sends from a port of its own; otherwise from the
    vehicle's, as what PX4 forwards.
    """

    when: When
    system: int = 1
    component: int = 1
    type: int = 2
    autopilot: int = 12
    says: frozenset[Saying] = frozenset({Saying.HEARTBEAT})
    mode: Order = Order.HOLD
    armed: bool = True
    position_n: Vec3 = (0.0, 0.0, 0.0)
    own_port: bool = True


@dataclass(frozen=True, slots=True)
class PortChange:
    """The vehicle sends to the companion from another port from now on: a radio that dialled in again."""

    when: When
