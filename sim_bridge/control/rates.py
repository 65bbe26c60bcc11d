"""Body rates -> torques: PX4's rate controller with the filters before and behind it.

The gains of PX4's defaults are stated as angular acceleration over rate error, measured on the machine they were made
for, and turned back into torque for the vehicle at hand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.frames import Vec3
from companion.vehicle import Vehicle
from sim_bridge.control.filters import ButterworthLowPass, LowPass
from sim_bridge.control.mixing import Mixer

SIH_ANGULAR_ACCELERATION = (113.137085, 113.137085, 13.333333)
"""rad/s^2 that a torque of 1 gives PX4's simulated quadrotor (1 kg, arms of 0.2 m, 5 N and 0.1 N m a motor)."""
PROPORTIONAL = (0.15, 0.15, 0.2)  # MC_ROLLRATE_P, MC_PITCHRATE_P, MC_YAWRATE_P
INTEGRAL = (0.2, 0.2, 0.1)
"""MC_ROLLRATE_I, MC_PITCHRATE_I, MC_YAWRATE_I (PX4's defaults)."""
DERIVATIVE = (0.003, 0.003, 0.0)
"""MC_ROLLRATE_D, MC_PITCHRATE_D, MC_YAWRATE_D (PX4's defaults)."""
INTEGRAL_MAX = 0.3
"""normalised torque: MC_RR_INT_LIM and its like (PX4's defaults)."""
LAG_TIMES_GAIN_MAX = 0.85
"""What the proportional gain (1/s) times the motors' lag may be; PX4's own figures are there."""
GYRO_CUTOFF = 40.0  # Hz, IMU_GYRO_CUTOFF
DERIVATIVE_CUTOFF = 20.0  # Hz, IMU_DGYRO_CUTOFF
YAW_TORQUE_CUTOFF = 2.0  # Hz, MC_YAW_TQ_CUTOFF
FULL_INTEGRATION = 1.0 / math.radians(400.0)
"""1/(rad/s): towards this rate error PX4 integrates less and less, against bounce-back after a flip."""

RatesWanted = tuple[float | None, float | None, float | None]
"""rad/s about each body axis; None leaves that axis without a demand (its present rate counts as right)."""


@dataclass(frozen=True, slots=True)
class RateGains:
    """Torque (in units of the mixer's 1) over rate error, its integral and the angular acceleration, by axis."""

    proportional: Vec3
    integral: Vec3
    derivative: Vec3


def gains_for(vehicle: Vehicle, mixer: Mixer, tuned: Vec3 = (1.0, 1.0, 1.0)) -> RateGains:
    """PX4's gains carried over to a vehicle, softer where its motors are too slow for them. ``tuned``: over these, by
    axis."""
    factors = []
    for axis in range(3):
        acceleration = mixer.torque_per_unit[axis] / vehicle.inertia[axis]
        stiffness = PROPORTIONAL[axis] * SIH_ANGULAR_ACCELERATION[axis]
        soften = min(1.0, LAG_TIMES_GAIN_MAX / (stiffness * vehicle.motor_lag)) if vehicle.motor_lag > 0.0 else 1.0
        factors.append(tuned[axis] * soften * SIH_ANGULAR_ACCELERATION[axis] / acceleration)
    a, b, c = factors
    return RateGains(
        (PROPORTIONAL[0] * a, PROPORTIONAL[1] * b, PROPORTIONAL[2] * c),
        (INTEGRAL[0] * a, INTEGRAL[1] * b, INTEGRAL[2] * c),
        (DERIVATIVE[0] * a, DERIVATIVE[1] * b, DERIVATIVE[2] * c),
    )


class Axis:
    """The controller of one axis. Rates in rad/s, torque in units of the mixer's 1, the step in s."""

    __slots__ = ("_d", "_gyro", "_i_step", "_last", "_p", "_per_step", "_turning", "integral")

    def __init__(self, proportional: float, integral: float, derivative: float, step: float) -> None:
        self._p, self._i_step, self._d = proportional, integral * step, derivative
        self._per_step = 1.0 / step
        self._gyro = ButterworthLowPass(GYRO_CUTOFF, step)
        self._turning = ButterworthLowPass(DERIVATIVE_CUTOFF, step)
        self._last = 0.0
        self.integral = 0.0

    def reset(self, rate: float) -> None:
        """Begin afresh at ``rate``: no integral, filters settled."""
        self._gyro.settle(rate)
        self._turning.settle(0.0)
        self._last = rate
        self.integral = 0.0

    def update(self, rate: float, wanted: float | None, lost: float, integrate: bool) -> float:
        """The torque. ``lost``: what saturation took of the last one; the integral does not grow that way."""
        filtered = self._gyro.update(rate)
        error = 0.0 if wanted is None else wanted - filtered
        torque = self._p * error + self.integral
        if self._d:
            torque -= self._d * self._turning.update((filtered - self._last) * self._per_step)
            self._last = filtered
        if integrate and error * lost <= 0.0:
            share = error * FULL_INTEGRATION
            share = 1.0 - share * share
            if share > 0.0:
                grown = self.integral + share * self._i_step * error
                if not -INTEGRAL_MAX <= grown <= INTEGRAL_MAX:
                    grown = math.copysign(INTEGRAL_MAX, grown)
                self.integral = grown
        return torque


class RateLoop:
    """The three axes together. Runs once a step of ``step`` s."""

    def __init__(self, gains: RateGains, step: float) -> None:
        self._roll, self._pitch, self._yaw = (
            Axis(p, i, d, step)
            for p, i, d in zip(gains.proportional, gains.integral, gains.derivative, strict=True)
        )  # fmt: skip
        self._yaw_torque = LowPass(YAW_TORQUE_CUTOFF, step)
        self.lost: Vec3 = (0.0, 0.0, 0.0)

    def reset(self, rates: Vec3) -> None:
        """Begin afresh at ``rates``."""
        self._roll.reset(rates[0])
        self._pitch.reset(rates[1])
        self._yaw.reset(rates[2])
        self._yaw_torque.value = 0.0
        self.lost = (0.0, 0.0, 0.0)

    def update(self, rates: Vec3, wanted: RatesWanted, integrate: bool) -> Vec3:
        """The torque for measured and wanted body rates (rad/s). ``integrate``: not while on the ground.

        ``lost`` is to be set to what saturation took of it.
        """
        l, m, n = self.lost  # noqa: E741  roll, pitch and yaw torque
        torque = self._yaw.update(rates[2], wanted[2], n, integrate)
        return (
            self._roll.update(rates[0], wanted[0], l, integrate),
            self._pitch.update(rates[1], wanted[1], m, integrate),
            self._yaw_torque.update(torque),
        )
