"""The law as it flies: factored, bounded, recorded once for a mission and a vehicle, printed as straight-line Python.

    outputs -> wanted snap or jerk (feedback) -> thrust and torques, or thrust and body rates (flatness)
    ``step``: that, recorded (recording.finish_step) and printed (calculus.straight)

Without bounds, drag and wrap it equals the paper's u = D^-1 (-b + v) to rounding; the tests hold it to that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol

from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor
from companion.calculus.vectors import Vector
from companion.frames import Heading, Matrix3, Vec3
from companion.law.closest import closest_point
from companion.law.errors import LawError
from companion.law.feedback import (
    Bounds,
    wanted_derivative,
    wanted_on_curve,
)
from companion.law.gains import Gains, Level, with_path_poles
from companion.law.implicit import Specification, arc_along, outputs
from companion.law.motion import Model
from companion.law.recording import finish_step, inputs, known_motion
from companion.law.speed_scale import SpeedScale
from companion.paths.arc import ArcTable
from companion.paths.curve import Curve
from companion.profiles import SpeedOverArc, StoppingSpeed, Yaw, YawOverArc
from companion.vehicle import Vehicle

ZERO3: Vec3 = (0.0, 0.0, 0.0)
"""N, m/s or rad/s: a vector of zeros. By definition."""
REGULARITY_MIN = 1e-4
"""Ratio: the least regularity (see Command) at which the law is evaluated. Engineering choice: rounding is 1e-12 of
it."""


Known = tuple[tuple[float, ...], ...]
"""What is known of a path where the vehicle is, as the law of it takes it: values with their derivatives."""


class Flying(NamedTuple):
    """The state the law is evaluated at. At the level of rates ``w_b`` and ``zeta_dot`` are not used."""

    p_n: Vec3  # m
    v_n: Vec3  # m/s
    r_nb: Matrix3  # body to world
    zeta: float  # N, the dynamic extension (Eq. 4)
    w_b: Vec3 = ZERO3  # rad/s
    zeta_dot: float = 0.0  # N/s
    disturbance: Vec3 = ZERO3  # m/s^2, world, beyond the paper's model
    drag: float = 0.0  # 1/s, likewise
    s: float = 0.0  # m, arc length near the closest point
    pole_scale: float = 1.0  # factor on the path poles


class Command(NamedTuple):
    """What the law asks for at one state.

    ``regularity`` is 0 where the law is singular: the sine of the angle between the gradients, or on a curve Q, 1 on it
    and 0 on its evolute.
    """

    zeta_derivative: float  # zeta_ddot, N/s^2 (motors), or zeta_dot, N/s (rates)
    turn: Vec3  # torques, N m (motors), or body rates, rad/s (rates)
    tangent: Vec3  # mu, world frame
    speed: float  # m/s, mu . V
    alpha: float  # m/s, the mission's speed here
    yaw: float  # rad, psi
    beta: float  # rad, the mission's heading here
    regularity: float  # 0 singular .. 1
    aligned: float = 1.0  # cosine of the angle between the thrust axis and the one that the errors ask for
    end_scale: float = 1.0  # on alpha; falls to 0 towards the open end of a path


class Law(Protocol):
    """The law of one mission for one vehicle at one level."""

    def __call__(self, flying: Flying, speed_scale: SpeedScale) -> Command:
        """The command at a state. LawError: singular, or outside the domain of the mission's expressions."""


def model_of(vehicle: Vehicle) -> Model:
    """What the law believes of ``vehicle``, with the drag its file gives."""
    return Model(vehicle.mass, Vector(*vehicle.inertia), vehicle.gravity, vehicle.drag)


@dataclass(frozen=True, slots=True)
class OverArc:
    """Speed and yaw of an implicit path where they are given over arc length (``table`` is the path's); None for what
    is a function of the position."""

    table: ArcTable
    speed: SpeedOverArc | None
    yaw: YawOverArc | None

    def at(self, flying: Flying) -> Known:
        """Each and three derivatives over arc length, at the point of the path next to the vehicle."""
        if self.speed is None and self.yaw is None:
            return ()
        s, _ = self.table.nearest(flying.p_n, flying.s)
        return tuple(each.at(s) for each in (self.speed, self.yaw) if each is not None)


@dataclass(frozen=True, slots=True)
class ImplicitLaw:
    """The law for h1 = h2 = 0."""

    step: Function
    over_arc: OverArc | None = None

    def __call__(self, flying: Flying, speed_scale: SpeedScale) -> Command:
        """See Law."""
        known = () if self.over_arc is None else self.over_arc.at(flying)
        command = _command_of(self.step, flying, speed_scale, known)
        if command.regularity < REGULARITY_MIN:
            raise LawError(f"singular: the gradients of h1 and h2 are parallel at {place(flying.p_n)}")
        return command


@dataclass(frozen=True)
class CurveLaw:
    """The law for a parametrised curve. The closest point is sought near ``flying.s``. Where the curve is open, the
    speed falls to zero towards the end that is flown to."""

    step: Function
    curve: Curve
    speed: SpeedOverArc
    yaw: Yaw
    bounded: bool

    def __call__(self, flying: Flying, speed_scale: SpeedScale) -> Command:
        """See Law."""
        curve = self.curve
        u, derivatives = curve.closest(flying.p_n, curve.parameter(flying.s))
        s = curve.arc(u)
        try:
            beta = self.yaw.at(s) if isinstance(self.yaw, YawOverArc) else _NO_YAW
            alpha = self.speed.at(s)
            flown = alpha if curve.closed else self._stopping(alpha[0] * speed_scale.value).of(s, alpha)
            known = (*derivatives, flown, beta)
        except (ValueError, ArithmeticError) as error:
            raise LawError(f"speed or yaw is not defined at s = {s:.2f} m: {error}") from None
        command = _command_of(self.step, flying, speed_scale, known)
        if not self.bounded and command.regularity < REGULARITY_MIN:
            raise LawError(f"singular: {place(flying.p_n)} is a centre of curvature of the path")
        if flown is alpha:
            return command
        return command._replace(alpha=alpha[0], end_scale=flown[0] / alpha[0])

    def _stopping(self, speed: float) -> StoppingSpeed:
        # -0.0 too has a sign: a leg back begins with it
        return self.stopping[0] if math.copysign(1.0, speed) > 0.0 else self.stopping[1]

    @cached_property
    def stopping(self) -> tuple[StoppingSpeed, StoppingSpeed]:
        """The speed towards the end of the curve, and towards its beginning."""
        length = self.curve.table.length
        return StoppingSpeed(self.speed, length, 1.0), StoppingSpeed(self.speed, 0.0, -1.0)


def _command_of(step: Function, flying: Flying, speed_scale: SpeedScale, known: Known) -> Command:
    p_n, v_n, r_nb, zeta, w_b, zeta_dot, disturbance, drag, _, poles = flying
    if not zeta > 0.0:
        raise LawError(f"singular: thrust {zeta:.3g} N")
    try:
        values = step(p_n, v_n, r_nb, w_b, zeta, zeta_dot, disturbance, drag, speed_scale, poles, *known)
    except (ValueError, ArithmeticError) as error:
        raise LawError(f"the law is not defined at {place(p_n)}: {error}") from None
    if not math.isfinite(sum(values)):
        raise LawError(f"the law is not finite at {place(p_n)}")
    return Command(values[0], values[1:4], values[4:7], *values[7:])


def place(p_n: Vec3) -> str:
    """A position as a pilot reads it."""
    return f"north {p_n[0]:z.1f}, east {p_n[1]:z.1f}, height {-p_n[2]:z.1f} m"


def implicit_law(
    specification: Specification, level: Level, model: Model, gains: Gains, bounds: Bounds | None,
    over_arc: OverArc | None = None,
) -> ImplicitLaw:  # fmt: skip
    """Records the law of an implicit path. ``over_arc``: what takes the place of the specification's alpha and beta.
    ValueError, ArithmeticError: an expression that is nowhere defined."""
    tape = Tape()
    model, motion, factor, pole_scale = inputs(tape, model)
    gains = with_path_poles(gains, pole_scale)
    if over_arc is not None and over_arc.speed is not None:
        a = tape.tuple_input("a0", "a1", "a2", "a3")
        specification = replace(specification, alpha=lambda p_n, mu: _along(a, arc_along(p_n, mu)))
    if over_arc is not None and over_arc.yaw is not None:
        b = tape.tuple_input("b0", "b1", "b2", "b3")
        specification = replace(specification, beta=lambda p_n, mu: _along(b, arc_along(p_n, mu)))
    known = outputs(specification, known_motion(level, model, motion), factor)
    wanted = wanted_derivative(known, level, gains, bounds)
    sine = known.grad1.cross(known.grad2).norm() / (known.grad1.norm() * known.grad2.norm())
    reported = (*known.mu.components(), known.mu @ motion.V, known.alpha)
    step = finish_step(
        tape, level, model, motion, gains, bounds, wanted, reported, known.beta, specification.heading, sine
    )
    return ImplicitLaw(step, over_arc)


def curve_law(
    curve: Curve, speed: SpeedOverArc, yaw: Yaw, level: Level, model: Model, gains: Gains, bounds: Bounds | None,
    direction: float, kind: Heading = Heading.PROJECTED,
) -> CurveLaw:  # fmt: skip
    """Records the law of a parametrised curve. The gains of h1 serve both normal directions. ``direction``: any number
    with the sign of the speed. ``kind``: of the heading that ``yaw`` gives."""
    tape = Tape()
    model, motion, factor, pole_scale = inputs(tape, model)
    gains = with_path_poles(gains, pole_scale)
    derivatives = tuple(Vector(*tape.tuple_input(*(f"g{k}{axis}" for axis in "xyz"))) for k in range(5))
    motion_derivatives = known_motion(level, model, motion)
    seen = closest_point(
        derivatives[: len(motion_derivatives) + 1], motion_derivatives, bounds.q_min if bounds else 0.0
    )
    alpha = _along(tape.tuple_input("a0", "a1", "a2", "a3"), seen.s)
    wanted = wanted_on_curve(seen, factor * alpha, level, gains, bounds)
    beta_inputs = tape.tuple_input("b0", "b1", "b2", "b3")
    if isinstance(yaw, YawOverArc):
        beta = _along(beta_inputs, seen.s)
    else:
        forward = 1.0 if direction >= 0.0 else -1.0
        travel = tuple(
            Taylor(column) * forward for column in zip(*(v.components() for v in _taylor(seen.T)), strict=True)
        )
        beta = yaw.value({}, seen.gamma, travel)
    reported = (*seen.T[0].components(), seen.vT[0], alpha.c[0])
    step = finish_step(tape, level, model, motion, gains, bounds, wanted, reported, beta, kind, seen.Q)
    return CurveLaw(step, curve, speed, yaw, bounds is not None)


_NO_YAW = (0.0, 0.0, 0.0, 0.0)
"""rad and its three derivatives over arc length: the heading of a path that asks for none. By definition."""


def _taylor(derivatives: tuple[Vector, ...]) -> tuple[Vector, ...]:
    """Time derivatives over their factorials, up to the second: all that a heading needs."""
    return (derivatives[0], derivatives[1], derivatives[2] * 0.5)


def _along(derivatives: Sequence[Scalar], s: Taylor) -> Taylor:
    """f(s(t)) as a series in time, from f and its derivatives over s."""
    total: Scalar = Taylor((derivatives[0], *(0.0 for _ in s.c[1:])))
    power: Scalar = 1.0
    factorial = 1.0
    for k, derivative in enumerate(derivatives[1:], 1):
        power, factorial = s * power, factorial * k
        total = total + power * (derivative / factorial)
    assert isinstance(total, Taylor)
    return total
