"""The law as it flies: factored, bounded, recorded once for a mission and a vehicle, printed as straight-line Python.

    outputs -> wanted snap or jerk (feedback) -> thrust and torques, or thrust and body rates (flatness)

Without bounds, drag and wrap it equals the paper's u = D^-1 (-b + v) to rounding; the tests hold it to that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Rotation, Vector
from companion.frames import Matrix3, Vec3
from companion.law.bare import LawError
from companion.law.feedback import (
    Bounds,
    clamped,
    wanted_derivative,
    wanted_heading_acceleration,
    wanted_heading_rate,
    yaw_divisor,
)
from companion.law.flatness import HeadingRate, body_acceleration, body_rates, heading, torques
from companion.law.gains import Gains, Level
from companion.law.implicit import Outputs, Specification, outputs
from companion.law.motion import Model, Motion, acceleration, jerk
from companion.vehicle import Vehicle


class Ramp(NamedTuple):
    """The factor on alpha and its time derivatives: 1 in steady flight, less while starting."""

    factor: float = 1.0
    rate: float = 0.0
    acceleration: float = 0.0


class Thrust(NamedTuple):
    """The dynamic extension (Eq. 4): zeta in N and zeta_dot in N/s, both states of the controller."""

    zeta: float
    zeta_dot: float = 0.0


class Command(NamedTuple):
    """What the law asks for at one state.

    ``zeta_derivative``: zeta_ddot (motors) or zeta_dot (rates). ``turn``: torques in N m (motors) or body rates in
    rad/s (rates). ``tangent``: mu, in the world frame. ``speed``: mu . V; ``alpha``: the mission's speed here. ``yaw``:
    psi and ``beta`` in rad. ``regularity``: the sine of the angle between the gradients, 0 where the law is singular.
    """

    zeta_derivative: float
    turn: Vec3
    tangent: Vec3
    speed: float
    alpha: float
    yaw: float
    beta: float
    regularity: float


def model_of(vehicle: Vehicle) -> Model:
    """What the law believes of ``vehicle``."""
    return Model(vehicle.mass, Vector(*vehicle.inertia), vehicle.gravity, vehicle.drag)


@dataclass(frozen=True, slots=True)
class ImplicitLaw:
    """The law for h1 = h2 = 0 at one level, for one vehicle and one set of gains."""

    level: Level
    step: Function

    def __call__(
        self, p_n: Vec3, v_n: Vec3, r_nb: Matrix3, w_b: Vec3, thrust: Thrust, disturbance: Vec3, ramp: Ramp
    ) -> Command:
        """The command at a state. LawError: singular, or outside the domain of the mission's expressions."""
        zeta, zeta_dot = thrust
        if not zeta > 0.0:
            raise LawError(f"singular: thrust {zeta:.3g} N")
        try:
            values = self.step(*p_n, *v_n, *r_nb, *w_b, zeta, zeta_dot, *disturbance, *ramp)
        except (ValueError, ArithmeticError) as error:
            raise LawError(f"the law is not defined at {_place(p_n)}: {error}") from None
        if not math.isfinite(sum(values)):
            raise LawError(f"the law is not finite at {_place(p_n)}")
        command = Command(values[0], values[1:4], values[4:7], *values[7:])  # type: ignore[arg-type]
        if command.regularity < REGULARITY_MIN:
            raise LawError(f"singular: the gradients of h1 and h2 are parallel at {_place(p_n)}")
        return command


REGULARITY_MIN = 1e-4


def _place(p_n: Vec3) -> str:
    return f"north {p_n[0]:.1f}, east {p_n[1]:.1f}, height {-p_n[2]:.1f} m"


def implicit_law(
    specification: Specification, level: Level, model: Model, gains: Gains, bounds: Bounds | None
) -> ImplicitLaw:
    """Records the law. ValueError or ArithmeticError: an expression that is nowhere defined."""
    record: Callable[..., Function] = _motors if level is Level.MOTORS else _rates
    return ImplicitLaw(level, record(specification, model, gains, bounds))


def _inputs(tape: Tape) -> tuple[Motion, Taylor]:
    X = Vector(*tape.inputs("x", "y", "z"))
    V = Vector(*tape.inputs("vx", "vy", "vz"))
    r = tape.inputs(*(f"r{i}{j}" for i in range(3) for j in range(3)))
    R = Rotation(Vector(r[0], r[3], r[6]), Vector(r[1], r[4], r[7]), Vector(r[2], r[5], r[8]))
    w = Vector(*tape.inputs("p", "q", "r"))
    zeta, zeta_dot = tape.inputs("zeta", "zeta_dot")
    disturbance = Vector(*tape.inputs("dx", "dy", "dz"))
    factor, rate, acceleration_ = tape.inputs("f", "f_dot", "f_ddot")
    return Motion(X, V, R, w, zeta, zeta_dot, disturbance), Taylor((factor, rate, 0.5 * acceleration_, 0.0, 0.0))


def _motors(specification: Specification, model: Model, gains: Gains, bounds: Bounds | None) -> Function:
    tape = Tape()
    motion, factor = _inputs(tape)
    A = acceleration(model, motion)
    J = jerk(model, motion, A)
    known = outputs(specification, (motion.X, motion.V, A, J), factor)
    snap = wanted_derivative(known, Level.MOTORS, gains, bounds)
    psi = heading(motion.R)
    psi_dot = HeadingRate(motion.R).of(motion.w)
    psi_ddot = wanted_heading_acceleration(psi, psi_dot, known.beta, gains, bounds)
    divisor = yaw_divisor(motion.R.e3.z, bounds)
    zeta_ddot, w_dot = body_acceleration(model, motion, snap, J, psi_ddot, divisor)
    if bounds is not None:
        w_dot.z = clamped(w_dot.z, bounds.yaw_acceleration)
    turn = torques(model, motion.w, w_dot)
    return tape.function("motors", [zeta_ddot, *turn.components(), *_told(motion, known, psi)])


def _rates(specification: Specification, model: Model, gains: Gains, bounds: Bounds | None) -> Function:
    tape = Tape()
    motion, factor = _inputs(tape)
    A = acceleration(model, motion)
    known = outputs(specification, (motion.X, motion.V, A), factor)
    J = wanted_derivative(known, Level.RATES, gains, bounds)
    psi = heading(motion.R)
    psi_dot = wanted_heading_rate(psi, known.beta, gains)
    zeta_dot, w = body_rates(model, motion, J, A, psi_dot, yaw_divisor(motion.R.e3.z, bounds))
    if bounds is not None:
        w.z = clamped(w.z, bounds.yaw_rate)
    return tape.function("rates", [zeta_dot, *w.components(), *_told(motion, known, psi)])


def _told(motion: Motion, known: Outputs, psi: Scalar) -> tuple[Scalar, ...]:
    """What the flight reports beside the command: mu, mu . V, alpha, psi, beta, regularity."""
    sine = known.grad1.cross(known.grad2).norm() / (known.grad1.norm() * known.grad2.norm())
    return (*known.mu.components(), known.mu @ motion.V, known.alpha, psi, known.beta.derivative(0), sine)
