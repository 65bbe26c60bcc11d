"""Body rates and thrust as a setpoint: as they are, or as the attitude that PX4's own loop turns back into them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from companion.frames import Quaternion, Vec3, multiply, normalised
from companion.vehicle import AttitudeSetpoint, RateSetpoint, Setpoint, Tuning

PX4_GAINS: Vec3 = (6.5, 6.5, 2.8)
"""1/s, of roll, pitch and yaw, where the vehicle does not say MC_ROLL_P, MC_PITCH_P, MC_YAW_P: PX4's defaults until
June 2026 (since then 4.0 for roll and pitch). The larger is the safe guess: the vehicle then turns slower than
commanded, not faster."""
YAW_WEIGHT = 0.4
"""Factor on the yaw error. PX4's default of MC_YAW_WEIGHT."""
HALF_ERROR_MAX = 0.9
"""Ratio: sine of half the tilt error, at most: 128 degrees. Engineering choice: short of the singularity at 180."""
HALF_TWIST_MAX = 0.5
"""Ratio: sine of half the shortened twist, at most. Engineering choice: 2.6 rad of yaw error."""


class Encoding(Protocol):
    """How rates go out."""

    @property
    def needs_attitude(self) -> bool:
        """Whether the attitude in which the command will act has a say."""

    @property
    def smoothing(self) -> float:
        """s that the autopilot smooths what is sent before its loops follow it."""

    def setpoint(self, rates_b: Vec3, thrust: float, q_nb: Quaternion) -> Setpoint:
        """The setpoint that asks for these rates (rad/s) of a vehicle whose attitude will be ``q_nb``."""

    def level_setpoint(self, rates_b: Vec3, thrust: float, q_nb: Quaternion) -> Setpoint:
        """The setpoint that levels a vehicle of attitude ``q_nb``; ``rates_b`` would do it."""


@dataclass(frozen=True, slots=True)
class AsRates:
    """SET_ATTITUDE_TARGET without the attitude: PX4's rate loop flies them."""

    needs_attitude: bool = False
    smoothing: float = 0.0

    def setpoint(self, rates_b: Vec3, thrust: float, q_nb: Quaternion) -> RateSetpoint:
        """See Encoding."""
        return RateSetpoint(rates_b, thrust)

    def level_setpoint(self, rates_b: Vec3, thrust: float, q_nb: Quaternion) -> RateSetpoint:
        """See Encoding."""
        return RateSetpoint(rates_b, thrust)


@dataclass(frozen=True, slots=True)
class AsAttitude:
    """The attitude q * exp(w/K), in the exact form of PX4's controller (Brescianini et al.): tilt first, nose second.

    Its attitude error is a swing (about body x and y) after a twist about the thrust axis, shortened by MC_YAW_WEIGHT:
    rates = 2 K (swing * shortened twist). That is solved for swing and twist. ``gains``: 1/s. From 1.18 on PX4 smooths
    the attitude first (MC_REF_W_N): the error it sees is against the attitude that was sent ``smoothing`` s ago.
    """

    gains: Vec3 = PX4_GAINS
    smoothing: float = 0.0
    needs_attitude: bool = True

    def setpoint(self, rates_b: Vec3, thrust: float, q_nb: Quaternion) -> AttitudeSetpoint:
        """See Encoding. Beyond what an attitude can ask for (an error of half a turn) it asks for as much as it can."""
        kx, ky, kz = self.gains
        a, b, c = 0.5 * rates_b[0] / kx, 0.5 * rates_b[1] / ky, 0.5 * rates_b[2] / kz * YAW_WEIGHT
        size = math.sqrt(a * a + b * b)
        if size > HALF_ERROR_MAX:
            a, b, size = HALF_ERROR_MAX * a / size, HALF_ERROR_MAX * b / size, HALF_ERROR_MAX
        w = math.sqrt(1.0 - size * size)
        sine = min(max(c / w, -HALF_TWIST_MAX), HALF_TWIST_MAX)
        cosine = math.sqrt(1.0 - sine * sine)
        x, y = cosine * a - sine * b, cosine * b + sine * a
        half_twist = math.asin(sine) / YAW_WEIGHT
        ct, st = math.cos(half_twist), math.sin(half_twist)
        error = (w * ct, x * ct + y * st, y * ct - x * st, w * st)
        return AttitudeSetpoint(normalised(multiply(q_nb, error)), thrust)

    def level_setpoint(self, rates_b: Vec3, thrust: float, q_nb: Quaternion) -> AttitudeSetpoint:
        """See Encoding: the heading alone."""
        w, _, _, z = q_nb
        return AttitudeSetpoint(normalised((w, 0.0, 0.0, z)) if w * w + z * z > 1e-6 else (1.0, 0.0, 0.0, 0.0), thrust)


def as_attitude(tuning: Tuning) -> AsAttitude:
    """For a vehicle's own gains."""
    gains = (tuning.roll_p, tuning.pitch_p, tuning.yaw_p)
    kx, ky, kz = (usual if own is None else own for own, usual in zip(gains, PX4_GAINS, strict=True))
    # critically damped: what changes slowly comes out 2 / wn late
    smoothing = 2.0 / tuning.smoothing if tuning.smoothing else 0.0
    return AsAttitude((kx, ky, kz), smoothing)
