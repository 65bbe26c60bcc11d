"""How the vehicle's idea of its state differs from the truth."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.frames import Vec3

NONE: Vec3 = (0.0, 0.0, 0.0)
"""No error."""


@dataclass(frozen=True, slots=True)
class Noise:
    """An error of three axes: ``white`` is new at every step, ``wander`` is a first-order Gauss-Markov process with
    the time constant ``wander_time`` (s), or where it is ``smooth`` two such lags in a row; at the start the wander is
    as large as ``start``, and comes to its own size in ``start_time`` (s); ``bias`` is drawn once. Standard
    deviations."""

    white: Vec3 = NONE
    wander: Vec3 = NONE
    wander_time: float = 1.0
    smooth: bool = False
    start: Vec3 | None = None
    start_time: float = 10.0
    bias: Vec3 = NONE

    def __bool__(self) -> bool:
        return any(self.white) or any(self.wander) or any(self.start or NONE) or any(self.bias)


@dataclass(frozen=True, slots=True)
class Drift:
    """A smooth wander of the position that the velocity does not show, as corrections by GPS leave it in PX4's
    output: the velocity is then not quite the derivative of the position.

    ``speed``: standard deviation of the difference, m/s; ``time``: s. The position's own is speed times time.
    """

    speed: Vec3 = NONE
    time: float = 1.0

    def __bool__(self) -> bool:
        return any(self.speed)


@dataclass(frozen=True, slots=True)
class Errors:
    """Everything that is wrong with an estimate: position m, velocity m/s (NED), attitude rad (a small turn about the
    body's axes, or where ``attitude_in_world`` about north, east and down, as the tilt error of an EKF is), gyro rad/s,
    accelerometer m/s^2 (what HIGHRES_IMU and SCALED_IMU report; nothing flies by it)."""

    position: Noise = field(default_factory=Noise)
    velocity: Noise = field(default_factory=Noise)
    attitude: Noise = field(default_factory=Noise)
    gyro: Noise = field(default_factory=Noise)
    drift: Drift = field(default_factory=Drift)
    accelerometer: Noise = field(default_factory=Noise)
    attitude_in_world: bool = False

    def __bool__(self) -> bool:
        errors = (self.position, self.velocity, self.attitude, self.gyro, self.drift, self.accelerometer)
        return any(map(bool, errors))
