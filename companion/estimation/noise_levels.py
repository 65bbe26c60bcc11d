"""How noisy the vehicle's own estimate and the air are, as the Kalman filter takes them."""

from __future__ import annotations

from typing import NamedTuple

from companion.frames import Vec3


class NoiseLevels(NamedTuple):
    """How noisy it is. ``position`` m^2, ``velocity`` m^2/s^2: variances of the measurements, sample by sample.
    ``wander``, ``velocity_error`` (m/s)^2, ``gust`` (m/s^2)^2: stationary variances of U, B and W of each axis.
    ``disturbance_q`` m^2/s^5: process noise of D of each axis; ``heading_error`` rad^2: stationary variance of E;
    ``tilt_error`` rad^2: of the tilt error, which lifts or lowers a thrust that leans."""

    position: float
    velocity: float
    wander: Vec3
    velocity_error: Vec3
    gust: Vec3
    disturbance_q: Vec3
    heading_error: float
    tilt_error: float
