"""The model of motors and body: what stands between a motor command and what the vehicle does.

    tau' = (tau_cmd - tau) / motor_lag           thrust and torques (the wrench), as the rotors make them
    J w' = tau - w x J w + J (trim - damping w)  Eq. (2), with a disturbance of the turning

The trim is what the model does not know: rotors that do not match, a centre of mass beside its place. It is observed
from the gyro; what of it follows the body rates is found as their damping (``angular_damping``). Both are taken out of
the torques that are asked for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.predictor import ForceModel, PredictedState
from companion.estimation.rate_loop_model import STEP, active_command, thrust_transition
from companion.estimation.translation import acceleration
from companion.frames import Quaternion, Vec3, body_z_axis, clamped, from_rotation_vector, multiply, normalised

Wrench = tuple[float, float, float, float]
"""Thrust (N) and torques about the body axes (N m)."""

TURN_OBSERVER_POLE = 6.0
"""1/s: both poles of the observer of body rates and trim at -6 1/s: the trim of a motor that fails is known after 0.3
s, and a gyro that shakes by 0.09 rad/s leaves a quarter of that in the rates. Engineering choice."""
TURN_OBSERVER = (2.0 * TURN_OBSERVER_POLE, TURN_OBSERVER_POLE**2)
"""1/s, 1/s^2: gains from the gyro's innovation to the body rates and the trim. By definition of its poles."""
TURN_OBSERVER_STEP_MAX = 0.03
"""s, the longest step of the observer (explicit Euler), which keeps it stable at low rates. Engineering choice."""
TRIM_MAX = 40.0
"""rad/s^2, the largest trim. Engineering choice: a motor of an x500 that is dead."""


class Body(NamedTuple):
    """The model's figures. ``mass``: kg. ``inertia``: kg m^2, the diagonal of J. ``motor_lag``: s."""

    mass: float
    inertia: Vec3
    motor_lag: float


class TimedWrench(NamedTuple):
    """A command that acts from ``at`` (s, the vehicle's clock) on. ``wrench``: as commanded."""

    at: float
    wrench: Wrench


class BodyState(NamedTuple):
    """The state of the model. ``w_b``: rad/s, body rates. ``acting``: what the motors make of the commanded wrench.
    ``trim``: rad/s^2. ``damping``: 1/s."""

    w_b: Vec3
    acting: Wrench
    trim: Vec3 = (0.0, 0.0, 0.0)
    damping: Vec3 = (0.0, 0.0, 0.0)

    def turning(self, w_b: Vec3) -> Vec3:
        """rad/s^2, what turns the body at the rates ``w_b`` (rad/s) beside its motors."""
        (tp, tq, tr), (cp, cq, cr), (p, q, r) = self.trim, self.damping, w_b
        return (tp - cp * p, tq - cq * q, tr - cr * r)


def propagate_body(
    body_state: BodyState, body: Body, commands: tuple[TimedWrench, ...], begin: float, end: float
) -> tuple[BodyState, float]:
    """The state at ``end`` (s) under the commands in force since ``begin``, and the mean thrust (N) in between."""
    steps = max(1, math.ceil((end - begin) / STEP - 1e-9))
    h = (end - begin) / steps
    if h <= 0.0:
        return body_state, body_state.acting[0]
    total = 0.0
    for k in range(steps):
        command = active_command(commands, begin + (k + 0.5) * h).wrench
        body_state, thrust, _ = _step(body_state, body, command, h)
        total += thrust
    return body_state, total / steps


def correct_body_with_gyro(body_state: BodyState, measured_b: Vec3, dt: float) -> BodyState:
    """The observer's correction by the gyro (rad/s), ``dt`` s after the last one."""
    h = min(dt, TURN_OBSERVER_STEP_MAX)
    near, far = TURN_OBSERVER[0] * h, TURN_OBSERVER[1] * h
    (p, q, r), (tp, tq, tr) = body_state.w_b, body_state.trim
    ip, iq, ir = measured_b[0] - p, measured_b[1] - q, measured_b[2] - r
    return BodyState(
        (p + near * ip, q + near * iq, r + near * ir),
        body_state.acting,
        (
            clamped(tp + far * ip, -TRIM_MAX, TRIM_MAX),
            clamped(tq + far * iq, -TRIM_MAX, TRIM_MAX),
            clamped(tr + far * ir, -TRIM_MAX, TRIM_MAX),
        ),
        body_state.damping,
    )


def predict_body(
    p_n: Vec3, v_n: Vec3, q_nb: Quaternion, body_state: BodyState, forces: ForceModel, body: Body,
    commands: tuple[TimedWrench, ...], begin: float, horizon: float,
) -> PredictedState:  # fmt: skip
    """The state ``horizon`` s after ``begin`` (s, the vehicle's clock), under ``commands`` and the last of them held.

    ``p_n`` m, ``v_n`` m/s, ``q_nb`` and ``body_state``: at ``begin``. Steps of STEP at most: the attitude by the rate
    in the middle, the translation by the mean thrust along the mean axis and the drag of the velocity in the middle.
    """
    steps = max(1, math.ceil(horizon / STEP - 1e-9))
    h = horizon / steps
    half = 0.5 * h
    damping = 1.0 - half * forces.drag
    (x, y, z), (vx, vy, vz) = p_n, v_n
    axis = body_z_axis(q_nb)
    for k in range(steps):
        command = active_command(commands, begin + (k + 0.5) * h).wrench
        body_state, thrust, (p, q, r) = _step(body_state, body, command, h)
        q_nb = multiply(q_nb, from_rotation_vector((h * p, h * q, h * r)))
        old, axis = axis, body_z_axis(q_nb)
        pull = 0.5 * forces.thrust_scale * thrust / body.mass
        specific_thrust_n = (pull * (old[0] + axis[0]), pull * (old[1] + axis[1]), pull * (old[2] + axis[2]))
        ax, ay, az = acceleration(specific_thrust_n, (vx, vy, vz), forces.gravity, forces.drag, forces.disturbance_n)
        ax, ay, az = ax * damping, ay * damping, az * damping
        x, y, z = x + h * (vx + half * ax), y + h * (vy + half * ay), z + h * (vz + half * az)
        vx, vy, vz = vx + h * ax, vy + h * ay, vz + h * az
    return PredictedState((x, y, z), (vx, vy, vz), normalised(q_nb), body_state.w_b)


def _step(body_state: BodyState, body: Body, command: Wrench, h: float) -> tuple[BodyState, float, Vec3]:
    """The state ``h`` s later, the mean thrust (N), and the body rates in the middle (rad/s)."""
    w_b, (f, u2, u3, u4), trim, damping = body_state
    left, mean = thrust_transition(body.motor_lag, h)
    cf, c2, c3, c4 = command
    torque = (c2 + mean * (u2 - c2), c3 + mean * (u3 - c3), c4 + mean * (u4 - c4))
    half = 0.5 * h
    p, q, r = w_b
    a, b, c = _turning(w_b, torque, body.inertia, trim, damping)
    middle = (p + half * a, q + half * b, r + half * c)
    a, b, c = _turning(middle, torque, body.inertia, trim, damping)
    acting = (cf + left * (f - cf), c2 + left * (u2 - c2), c3 + left * (u3 - c3), c4 + left * (u4 - c4))
    later = BodyState((p + h * a, q + h * b, r + h * c), acting, trim, damping)
    return later, cf + mean * (f - cf), middle


def _turning(w_b: Vec3, torque: Vec3, inertia: Vec3, trim: Vec3, damping: Vec3) -> Vec3:
    """w', rad/s^2 (Eq. 2)."""
    (p, q, r), (jx, jy, jz) = w_b, inertia
    return (
        (torque[0] - (jz - jy) * q * r) / jx + trim[0] - damping[0] * p,
        (torque[1] - (jx - jz) * r * p) / jy + trim[1] - damping[1] * q,
        (torque[2] - (jy - jx) * p * q) / jz + trim[2] - damping[2] * r,
    )
