"""The predictor: the state at the time when a command acts, under the commands that are already on their way.

Dead time (the link) and the lag of the rate loop are bridged by integrating the model of the vehicle over both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Any, NamedTuple

from companion.calculus import machine_code
from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.estimation.rate_loop_model import (
    STEP,
    RateLoop,
    RateLoopState,
    TimedCommand,
    transitions_of,
)
from companion.frames import Quaternion, Vec3, normalised

Scalars = tuple[Scalar, ...]


class ForceModel(NamedTuple):
    """What is known of the forces.

    ``thrust_scale``: thrust made over thrust commanded. ``drag``: 1/s. ``disturbance_n``, ``gravity``: m/s^2.
    """

    thrust_scale: float
    drag: float
    disturbance_n: Vec3
    gravity: float


class PredictedState(NamedTuple):
    """``p_n``: m. ``v_n``: m/s. ``q_nb``: attitude. ``w_b``: rad/s."""

    p_n: Vec3
    v_n: Vec3
    q_nb: Quaternion
    w_b: Vec3


def predict(
    p_n: Vec3, v_n: Vec3, q_nb: Quaternion, rate_loop_state: RateLoopState, forces: ForceModel, rate_loop: RateLoop,
    commands: tuple[TimedCommand, ...], begin: float, horizon: float,
) -> PredictedState:  # fmt: skip
    """The state ``horizon`` s after ``begin`` (s, the vehicle's clock), under ``commands`` and the last of them held.

    ``p_n`` m, ``v_n`` m/s, ``q_nb`` and ``rate_loop_state``: at ``begin``. Steps of STEP at most: rates exactly, the
    attitude by the mean rate, the translation by the mean thrust and the drag of the velocity in the middle.
    """
    steps = max(1, math.ceil(horizon / STEP - 1e-9))
    h = round(horizon / steps, 6)
    active = _active_commands(commands, begin, h, steps)
    if machine_code.in_use:
        given = [h, *transitions_of(rate_loop, h), rate_loop.yaw_gain, p_n, v_n, q_nb, *rate_loop_state, *forces]
        for command in active:
            given += command[1:]
        p_n, v_n, q_nb, w_b = _recorded(steps)(*given)
    else:
        p_n, v_n, q_nb, w_b = _integrate(
            h, transitions_of(rate_loop, h), rate_loop.yaw_gain, p_n, v_n, q_nb, rate_loop_state, forces, active
        )
    return PredictedState(p_n, v_n, normalised(q_nb), w_b)


def _active_commands(commands: tuple[TimedCommand, ...], begin: float, h: float, steps: int) -> list[TimedCommand]:
    """Those that act in the middle of each of so many ``steps`` of ``h`` s from ``begin`` on."""
    active = []
    i, last = 0, len(commands) - 1
    t = begin + 0.5 * h
    for _ in range(steps):
        while i < last and commands[i + 1].at <= t:
            i += 1
        active.append(commands[i])
        t += h
    return active


def _integrate(
    h: Scalar, transitions: tuple[Scalars, Scalars, Scalars, Scalars], yaw_gain: Scalar, p_n: Scalars, v_n: Scalars,
    q_nb: Scalars, rate_loop_state: tuple[Scalars, Scalars, Scalar, Scalar],
    forces: tuple[Scalar, Scalar, Scalars, Scalar], active: Iterable[tuple[Any, Scalars, Scalar]],
) -> tuple[Any, Any, Any, Any]:  # fmt: skip
    """Steps of ``h`` s, each under its command: position, velocity, attitude, body rates. Floats, or symbols of a
    tape."""
    (yy, yd, dy, dd, ay, ad), (jj, jd, ej, edj, aj, adj), (zz, zd, ez, ed, az, bz), (left, mean) = transitions
    ay, ad, aj, adj, az, bz = 0.5 * ay, 0.5 * ad, 0.5 * aj, 0.5 * adj, 0.5 * az, 0.5 * bz  # of half the angles
    half = 0.5 * h
    (x, y, z), (vx, vy, vz) = p_n, v_n
    qw, qx, qy, qz = q_nb
    (wp, wq, wr), (pd, qd, rd), f, trim = rate_loop_state
    thrust_scale, drag, (north, east, down), gravity = forces
    down = down + gravity
    damping = 1.0 - half * drag  # drag acts on the velocity in the middle of the step
    ex, ey, ez_n = qx * qz + qw * qy, qy * qz - qw * qx, 0.5 - (qx * qx + qy * qy)  # half the thrust axis
    for _, (sp, sq, sr), commanded in active:
        sr = yaw_gain * (sr + trim)
        yp, yq, yr = wp - sp, wq - sq, wr - sr
        # half the angles turned in this step, each axis by its own loop
        hp, hq, hr = sp * half + ay * yp + ad * pd, sq * half + aj * yq + adj * qd, sr * half + az * yr + bz * rd
        wp, pd = sp + yy * yp + yd * pd, dy * yp + dd * pd
        wq, qd = sq + jj * yq + jd * qd, ej * yq + edj * qd
        wr, rd = sr + zz * yr + zd * rd, ez * yr + ed * rd
        turn2 = hp * hp + hq * hq + hr * hr
        cw, sw = 1.0 - 0.5 * turn2, 1.0 - turn2 / 6.0
        hp, hq, hr = hp * sw, hq * sw, hr * sw
        qw, qx, qy, qz = (
            qw * cw - qx * hp - qy * hq - qz * hr,
            qx * cw + qw * hp + qy * hr - qz * hq,
            qy * cw + qw * hq - qx * hr + qz * hp,
            qz * cw + qw * hr + qx * hq - qy * hp,
        )
        ox, oy, oz = ex, ey, ez_n
        ex, ey, ez_n = qx * qz + qw * qy, qy * qz - qw * qx, 0.5 - (qx * qx + qy * qy)
        pull = thrust_scale * (commanded + mean * (f - commanded))
        f = commanded + left * (f - commanded)
        # translation.acceleration, written out: here it is called more often than all else together
        ax = (north - pull * (ox + ex) - drag * vx) * damping
        ay_n = (east - pull * (oy + ey) - drag * vy) * damping
        az_n = (down - pull * (oz + ez_n) - drag * vz) * damping
        x, y, z = x + h * (vx + half * ax), y + h * (vy + half * ay_n), z + h * (vz + half * az_n)
        vx, vy, vz = vx + h * ax, vy + h * ay_n, vz + h * az_n
    return (x, y, z), (vx, vy, vz), (qw, qx, qy, qz), (wp, wq, wr)


@lru_cache(maxsize=64)
def _recorded(steps: int) -> Function:
    """``_integrate`` over so many steps, from what it takes and from rates and thrust of each command."""
    tape = Tape()

    def numbers(name: str, size: int) -> Any:
        return tape.tuple_input(*(f"{name}{i}" for i in range(size)))

    (h,) = tape.inputs("h")
    transitions = (numbers("roll", 6), numbers("pitch", 6), numbers("yaw", 6), numbers("thrust", 2))
    (yaw_gain,) = tape.inputs("yaw_gain")
    p_n, v_n, q_nb = numbers("p", 3), numbers("v", 3), numbers("q", 4)
    rate_loop_state = (numbers("w", 3), numbers("w_dot", 3), *tape.inputs("f", "trim"))
    forces = (*tape.inputs("k", "c"), numbers("d", 3), *tape.inputs("g"))
    active = [(None, numbers(f"rates{k}_", 3), *tape.inputs(f"f{k}")) for k in range(steps)]
    outputs = _integrate(h, transitions, yaw_gain, p_n, v_n, q_nb, rate_loop_state, forces, active)
    return machine_code.function_of(tape, "predict", outputs)
