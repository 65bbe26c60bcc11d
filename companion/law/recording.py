"""What every law records: its inputs, the motion known from them, and from a derivative to what is asked for."""

from __future__ import annotations

from companion.calculus import machine_code
from companion.calculus.scalar import Scalar, maximum
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Rotation, Vector
from companion.frames import Heading
from companion.law.feedback import (
    Bounds,
    WantedDerivatives,
    clamped,
    wanted_heading_acceleration,
    wanted_heading_rate,
    yaw_divisor,
)
from companion.law.flatness import HeadingRate, body_acceleration, body_rates, heading, torques
from companion.law.gains import Gains, Level
from companion.law.motion import Model, Motion, acceleration, jerk

WEIGHTLESS = 1e-3
"""m/s^2 of thrust over mass below which it has no direction. Engineering choice."""


def inputs(tape: Tape, model: Model) -> tuple[Model, Motion, Taylor, Scalar]:
    """The inputs every law has, in the order of ``Flying``, ``SpeedScale`` and the path poles: model, motion, the
    factor on alpha, the factor on the path poles."""
    X = Vector(*tape.tuple_input("x", "y", "z"))
    V = Vector(*tape.tuple_input("vx", "vy", "vz"))
    r = tape.tuple_input(*(f"r{i}{j}" for i in range(3) for j in range(3)))
    R = Rotation(Vector(r[0], r[3], r[6]), Vector(r[1], r[4], r[7]), Vector(r[2], r[5], r[8]))
    w = Vector(*tape.tuple_input("p", "q", "r"))
    zeta, zeta_dot = tape.inputs("zeta", "zeta_dot")
    disturbance = Vector(*tape.tuple_input("dx", "dy", "dz"))
    (drag,) = tape.inputs("c")
    factor, rate, acceleration_ = tape.tuple_input("f", "f_dot", "f_ddot")
    (pole_scale,) = tape.inputs("pole_scale")
    motion = Motion(X, V, R, w, zeta, zeta_dot, disturbance)
    speed = Taylor((factor, rate, 0.5 * acceleration_, 0.0, 0.0))
    return Model(model.m, model.J, model.g, drag), motion, speed, pole_scale


def known_motion(level: Level, model: Model, motion: Motion) -> tuple[Vector, ...]:
    """(X, V, A) for rates, (X, V, A, J) for motors."""
    A = acceleration(model, motion)
    known = (motion.X, motion.V, A)
    return (*known, jerk(model, motion, A)) if level is Level.MOTORS else known


def finish_step(
    tape: Tape, level: Level, model: Model, motion: Motion, gains: Gains, bounds: Bounds | None,
    wanted: WantedDerivatives, reported: tuple[Scalar, ...], beta: Taylor, kind: Heading, regularity: Scalar,
) -> Function:  # fmt: skip
    """From the wanted derivative of the position to thrust and turning, by flatness; and what the flight reports."""
    psi, rate = heading(motion.R, kind), HeadingRate(motion.R, kind)
    divisor = yaw_divisor(rate.by_r, bounds)
    A = acceleration(model, motion)
    if level is Level.MOTORS:
        psi_ddot = wanted_heading_acceleration(psi, rate.of(motion.w), beta, gains, bounds)
        J = jerk(model, motion, A)
        zeta_derivative, w_dot = body_acceleration(model, motion, wanted.derivative, J, psi_ddot, rate, divisor)
        if bounds is not None:
            w_dot.z = clamped(w_dot.z, bounds.yaw_acceleration)
        turn = torques(model, motion.w, w_dot)
    else:
        psi_dot = wanted_heading_rate(psi, beta, gains, bounds)
        zeta_derivative, turn = body_rates(model, motion, wanted.derivative, A, psi_dot, rate, divisor)
        if bounds is not None:
            turn.z = clamped(turn.z, bounds.yaw_rate)
    lift = motion.R.e3 * (motion.zeta / model.m) - wanted.missing
    aligned = (lift @ motion.R.e3) / maximum(lift.norm(), WEIGHTLESS)
    return machine_code.function_of(
        tape,
        level.name.lower(),
        [zeta_derivative, *turn.components(), *reported, psi, beta.derivative(0), regularity, aligned],
    )
