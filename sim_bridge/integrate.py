"""Runge-Kutta of fourth order with a fixed step, unrolled for the motion of a rigid body."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

from companion.calculus import machine_code, scalar
from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.frames import Vec3
from sim_bridge.rigid_body import Body, Derivative, F, derivative_of
from sim_bridge.rotors import Four

Motion = tuple[F, F, F, F, F, F, F, F, F, F, F, F, F]
"""(p_n, v_n, q_nb, w_b)"""
Advance = Callable[[Motion, tuple[Four, Four, Four], Vec3, Vec3, float], Motion]
"""One step, in which the wind (m/s), what else accelerates (m/s^2) and what else turns about z (N m) stay as they are:
from the motion and the thrusts at the step's beginning, middle and end to the next motion."""


def runge_kutta(derivative: Derivative, step: float, sqrt: Callable[[Scalar], Scalar] = math.sqrt) -> Advance:
    """One step of ``step`` s under ``derivative``; the quaternion comes out at unit length. ``sqrt``: of its numbers.

    The classical scheme, with the position's stages summed by hand: since the derivative does not depend on the
    position, they are those of the velocity one stage earlier.
    """
    half, sixth, square = 0.5 * step, step / 6.0, step * step / 6.0

    def advance(
        motion: Motion, thrusts: tuple[Four, Four, Four], wind_n: Vec3, given: Vec3, turn: float
    ) -> Motion:  # fmt: skip
        pn, pe, pd, vn, ve, vd, qw, qx, qy, qz, p, q, r = motion
        (f0, f1, f2, f3), (g0, g1, g2, g3), (h0, h1, h2, h3) = thrusts
        un, ue, ud = vn - wind_n[0], ve - wind_n[1], vd - wind_n[2]
        an, ae, ad = given
        a1, b1, c1, w1, x1, y1, z1, p1, q1, r1 = derivative(
            un, ue, ud, qw, qx, qy, qz, p, q, r, f0, f1, f2, f3, an, ae, ad, turn
        )
        a2, b2, c2, w2, x2, y2, z2, p2, q2, r2 = derivative(
            un + half * a1, ue + half * b1, ud + half * c1,
            qw + half * w1, qx + half * x1, qy + half * y1, qz + half * z1,
            p + half * p1, q + half * q1, r + half * r1, g0, g1, g2, g3, an, ae, ad, turn,
        )  # fmt: skip
        a3, b3, c3, w3, x3, y3, z3, p3, q3, r3 = derivative(
            un + half * a2, ue + half * b2, ud + half * c2,
            qw + half * w2, qx + half * x2, qy + half * y2, qz + half * z2,
            p + half * p2, q + half * q2, r + half * r2, g0, g1, g2, g3, an, ae, ad, turn,
        )  # fmt: skip
        a4, b4, c4, w4, x4, y4, z4, p4, q4, r4 = derivative(
            un + step * a3, ue + step * b3, ud + step * c3,
            qw + step * w3, qx + step * x3, qy + step * y3, qz + step * z3,
            p + step * p3, q + step * q3, r + step * r3, h0, h1, h2, h3, an, ae, ad, turn,
        )  # fmt: skip
        qw += sixth * (w1 + 2.0 * (w2 + w3) + w4)
        qx += sixth * (x1 + 2.0 * (x2 + x3) + x4)
        qy += sixth * (y1 + 2.0 * (y2 + y3) + y4)
        qz += sixth * (z1 + 2.0 * (z2 + z3) + z4)
        unit = 1.0 / sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
        return (
            pn + step * vn + square * (a1 + a2 + a3),
            pe + step * ve + square * (b1 + b2 + b3),
            pd + step * vd + square * (c1 + c2 + c3),
            vn + sixth * (a1 + 2.0 * (a2 + a3) + a4),
            ve + sixth * (b1 + 2.0 * (b2 + b3) + b4),
            vd + sixth * (c1 + 2.0 * (c2 + c3) + c4),
            qw * unit, qx * unit, qy * unit, qz * unit,
            p + sixth * (p1 + 2.0 * (p2 + p3) + p4),
            q + sixth * (q1 + 2.0 * (q2 + q3) + q4),
            r + sixth * (r1 + 2.0 * (r2 + r3) + r4),
        )  # fmt: skip

    return advance


def advance_of(body: Body, step: float) -> Advance:
    """One step of ``step`` s of a body's motion: as machine code where that is in use, with the same numbers."""
    if not machine_code.in_use:
        return runge_kutta(derivative_of(body), step)
    more_drag = (body.rotor_drag, body.quadratic_drag)
    function = _recorded(step, any(more_drag))
    known: tuple[float, ...] = (body.mass, *body.inertia, body.drag, body.angular_drag)
    for torque in body.torques_per_newton:
        known += torque
    known += more_drag if any(more_drag) else ()

    def advance(
        motion: Motion, thrusts: tuple[Four, Four, Four], wind_n: Vec3, given: Vec3, turn: float
    ) -> Motion:  # fmt: skip
        return function(known, motion, *thrusts, wind_n, given, turn)

    return advance


@lru_cache(maxsize=16)
def _recorded(step: float, has_more_drag: bool) -> Function:
    """A step of any body: a function of what ``derivative_of`` takes of it, and then of what ``Advance`` takes."""
    tape = Tape()
    arms = [f"{axis}{i}" for i in range(4) for axis in "lmn"]
    names = ("m", "jx", "jy", "jz", "c", "d", *arms, *(("c_r", "c_2") if has_more_drag else ()))
    mass, jx, jy, jz, drag, angular_drag, *rest = tape.tuple_input(*names)
    a, b, c, d = (rest[i : i + 3] for i in range(0, 12, 3))
    more_drag = rest[12:] if has_more_drag else (0.0, 0.0)
    # symbols in the place of floats, for which Body and Advance are typed
    body = Body(mass, (jx, jy, jz), 0.0, drag, angular_drag, (a, b, c, d), *more_drag)  # type: ignore[arg-type]
    motion = tape.tuple_input("pn", "pe", "pd", "vn", "ve", "vd", "qw", "qx", "qy", "qz", "p", "q", "r")
    first, middle, last = (tape.tuple_input(*(f"{when}{i}" for i in range(4))) for when in "fgh")
    wind_n, given = tape.tuple_input("wn", "we", "wd"), tape.tuple_input("an", "ae", "ad")
    (turn,) = tape.inputs("turn")
    advance = runge_kutta(derivative_of(body, scalar.sqrt), step, scalar.sqrt)
    outputs = advance(motion, (first, middle, last), wind_n, given, turn)  # type: ignore[arg-type]
    return machine_code.function_of(tape, "advance", outputs)
