"""The vehicle as it is: what its vehicle file describes."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

from companion.frames import Vec3

GRAVITY = 9.80665
"""m/s^2, the standard value and PX4's own."""


class CompanionError(Exception):
    """The base of every error this project raises on purpose."""


class Spin(enum.Enum):
    """The sense of a rotor's turning, seen from above."""

    CCW = "ccw"
    CW = "cw"

    @property
    def reaction(self) -> float:
        """The sign of the torque about body z (down) that the rotor's drag puts on the frame.

        A rotor turning counter-clockwise seen from above pushes the frame clockwise seen from above, which is positive
        about an axis that points down.
        """
        return 1.0 if self is Spin.CCW else -1.0


@dataclass(frozen=True, slots=True)
class Rotor:
    """One rotor: where it sits, which way it turns, what a command gives.

    ``position_b``: m, FRD from the centre of mass. ``thrust_max``: N at command 1 (thrust is linear in the command).
    ``torque_per_thrust``: m, reaction torque over thrust, the paper's 1/c. ``command``: the range of commands it takes.
    """

    position_b: Vec3
    spin: Spin
    thrust_max: float
    torque_per_thrust: float
    command: tuple[float, float] = (0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Limits:
    """What the vehicle may be asked for: tilt (rad), body rates (rad/s), speed (m/s). ``failure_detector``: rad of tilt
    at which its autopilot ends the flight (PX4's FD_FAIL_R and FD_FAIL_P)."""

    tilt: float = math.radians(45.0)
    body_rates: Vec3 = (math.radians(220.0), math.radians(220.0), math.radians(85.0))
    speed: float = 12.0
    failure_detector: float = math.radians(60.0)

    @property
    def caught_tilt(self) -> float:
        """rad at which a vehicle that flies without PX4's rate loop is handed back, so that PX4 can still catch it."""
        return min(max(CAUGHT_TILT, self.tilt + OVER_TILT), self.failure_detector - TILT_MARGIN)


TILT_MARGIN = math.radians(2.0)
"""rad that both what is asked for and our own guard stay under the vehicle's failure detector; and that the steady tilt
of a path may be over its limit. Engineering choice."""
CAUGHT_TILT = math.radians(50.0)
"""rad from which PX4's Hold caught a vehicle on motors twice, falling 0.7 and 1.6 m. Flown on PX4."""
OVER_TILT = math.radians(5.0)
"""rad over the tilt that a vehicle may be asked for, where that is more. Engineering choice."""


class MotorInterface(enum.Enum):
    """Who mixes: ``PX4`` takes rates or attitudes and mixes itself; ``DIRECT`` takes motor commands."""

    PX4 = "px4"
    DIRECT = "direct"


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A quadrotor as its vehicle file describes it."""

    name: str
    mass: float  # kg
    inertia: Vec3  # kg m^2, the diagonal of J
    rotors: tuple[Rotor, ...]  # in the autopilot's motor order
    gravity: float = GRAVITY  # m/s^2
    motor_lag: float = 0.0  # s
    drag: float = 0.0  # 1/s, linear, over mass
    hover_thrust: float | None = None  # normalised; None: to be learned
    rate_loop_lag: float = 0.06  # s
    dead_time: float = 0.01  # s, from a state to the moment its command acts
    motors: MotorInterface = MotorInterface.PX4  # who mixes
    state_rate: float = 250.0  # Hz, how often it can stream its state
    limits: Limits | None = field(default_factory=Limits)  # None where the bare mathematics is wanted

    @property
    def weight(self) -> float:
        """N."""
        return self.mass * self.gravity

    @property
    def thrust_max(self) -> float:
        """N, all rotors at the top of their command range."""
        return sum(rotor.thrust_max * rotor.command[1] for rotor in self.rotors)
