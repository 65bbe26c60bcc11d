"""What a flight finds out about its vehicle, step by step: the Kalman filter, and what keeps it honest.

freeze     thrust scale and drag are not learned for a while after anything that is not the model: a clipped
           command, a thrust at its bound, a vehicle that is held or stopped
ball       the disturbance stays near its own slow mean: a vehicle held by force is not taken for one in a storm,
           and does not leap away when it is released
noise      how far measurements are trusted follows from how far they miss what was expected
seat       after a jump of the estimator or of the vehicle, place and velocity are taken as they are now
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.kalman import DRAG, KAPPA, SMOOTH_X, Belief, Surprise, calmed, first_belief, seated, stepped
from companion.frames import Matrix3, Vec3

FREEZE_FOR = 0.4
"""s without learning after anything the model does not know."""
KAPPA_RANGE, DRAG_RANGE = (0.45, 2.2), (0.0, 2.5)
BALL, FIRST_BALL = 2.0, 8.0
"""m/s^2, how far the disturbance may be from its slow mean; at first it may be anywhere a wind could put it."""
FIRST_FOR, SLOW_TIME, FIRST_SLOW_TIME = 4.0, 5.0, 0.5
"""s."""
KAPPA_DOUBT, DRAG_DOUBT = 0.2, 0.7
NOISE_TIME = 2.0
"""s over which the misses are averaged."""
NOISE_MIN, NOISE_MAX = (SMOOTH_X, 4e-3**2), (0.05**2, 0.2**2)
"""Variances of position (m^2) and velocity (m^2/s^2): PX4's own smooth estimate, and the worst that is still flown."""
JUMP_P, JUMP_V, JUMP_SIGMAS = 0.25, 0.5, 10.0
CALM = 1.0
"""m/s, below which a lean is taken for the wind's."""
STILL, MISSING, MISSING_TIME = 0.25, 0.5, 1.0
"""m/s: slower than this a vehicle that is to move may be held; it is when so much velocity is missing that it should
have come to in the last second or so (s)."""
LET_GO = 0.12
"""m/s: so fast towards where its thrust points a vehicle that was held is free again."""
CONVERGED = 0.03
"""Standard deviation of the thrust scale at which it is known."""
FIRST_LEARNING = 0.3
"""s of flight before anything is called converged."""


class Prior(NamedTuple):
    """What is believed before the flight: value and standard deviation of the thrust scale and of the drag (1/s)."""

    kappa: tuple[float, float] = (1.0, KAPPA_DOUBT)
    drag: tuple[float, float] = (0.0, DRAG_DOUBT)


class Observed(NamedTuple):
    """What is known at a stamp. ``belief``: of the vehicle. ``noise``: variances of measured position and velocity.
    ``slow_n``: m/s^2, the slow mean of the disturbance. ``frozen``: s left without learning. ``flown``: s since the
    first step. ``held``: whether the disturbance stands at the edge of its ball.
    ``missing_n``: m/s, the velocity it should have come to since it stands still."""

    belief: Belief
    noise: tuple[float, float]
    slow_n: Vec3
    frozen: float = 0.0
    flown: float = 0.0
    held: bool = False
    missing_n: Vec3 = (0.0, 0.0, 0.0)

    @property
    def stuck(self) -> bool:
        """Whether something holds the vehicle."""
        x, y, z = self.missing_n
        return x * x + y * y + z * z > MISSING * MISSING

    @property
    def converged(self) -> bool:
        """Whether the scale of the thrust is known well enough to follow a path."""
        return self.flown >= FIRST_LEARNING and self.belief.variance(KAPPA) < (CONVERGED * self.belief.kappa) ** 2


class Seen(NamedTuple):
    """A state to learn from, ``dt`` s after the last one. ``lift_n``: m/s^2, the mean lift since then. ``limited``: the
    last command met a limit. ``jumped``: the vehicle says that its estimate was reset. ``moving``: it was told to fly
    somewhere."""

    dt: float
    lift_n: Vec3
    p_n: Vec3
    v_n: Vec3
    limited: bool = False
    jumped: bool = False
    moving: bool = False


def first_observed(p_n: Vec3, v_n: Vec3, r_nb: Matrix3, gravity: float, prior: Prior) -> Observed:
    """Before the first step. A vehicle that hovers leans into the wind, so that the lean says what the wind does."""
    lean: Vec3 = (0.0, 0.0, 0.0)
    if math.hypot(*v_n) < CALM and r_nb[8] > 0.5:
        lean = (gravity * r_nb[2] / r_nb[8], gravity * r_nb[5] / r_nb[8], 0.0)
    return Observed(first_belief(p_n, v_n, lean, prior.kappa, prior.drag), NOISE_MIN, lean)


def expected(belief: Belief, seen: Seen, gravity: float) -> tuple[Vec3, Vec3]:
    """Where a state would be and how fast, by what was believed before it came."""
    (px, py, pz), (vx, vy, vz), (fx, fy, fz) = belief.p_n, belief.v_n, seen.lift_n
    (dx, dy, dz), kappa, c, h = belief.disturbance_n, belief.kappa, belief.drag, seen.dt
    half = 0.5 * h
    ax, ay, az = dx - kappa * fx - c * vx, dy - kappa * fy - c * vy, gravity + dz - kappa * fz - c * vz
    return (
        (px + h * (vx + half * ax), py + h * (vy + half * ay), pz + h * (vz + half * az)),
        (vx + h * ax, vy + h * ay, vz + h * az),
    )


def can_wait(known: Observed, seen: Seen, p_n: Vec3, v_n: Vec3) -> bool:
    """Whether a command may be made of what was expected (``p_n``, ``v_n``) and the state be learned from afterwards:
    not after a jump, nor while something holds the vehicle."""
    if seen.jumped or known.stuck:
        return False
    (x, y, z), (vx, vy, vz) = seen.p_n, seen.v_n
    return (
        max(abs(x - p_n[0]), abs(y - p_n[1]), abs(z - p_n[2])) < JUMP_P
        and max(abs(vx - v_n[0]), abs(vy - v_n[1]), abs(vz - v_n[2])) < JUMP_V
    )


def observed(known: Observed, seen: Seen, gravity: float) -> Observed:
    """``known`` after another state."""
    dt, lift_n, p_n, v_n, limited, jumped, moving = seen
    frozen = FREEZE_FOR if limited else max(0.0, known.frozen - dt)
    learning = frozen == 0.0
    belief, surprise = stepped(known.belief, dt, lift_n, gravity, p_n, v_n, known.noise, learning)
    flown = known.flown + dt
    missing_n = _missing(known, dt, lift_n, gravity, v_n) if moving else (0.0, 0.0, 0.0)
    known = known._replace(missing_n=missing_n)
    if known.stuck:
        return known._replace(belief=calmed(known.belief, p_n, v_n, known.slow_n), frozen=FREEZE_FOR, flown=flown)
    if jumped or _leapt(surprise):
        there = seated(known.belief, p_n, v_n)
        return known._replace(belief=there, frozen=FREEZE_FOR, flown=flown)
    belief, slow_n, held = _bounded(belief, known.slow_n, dt, flown)
    noise = known.noise if held or not learning else _noise(known.noise, surprise, dt)
    return Observed(belief, noise, slow_n, FREEZE_FOR if held else frozen, flown, held, missing_n)


def _missing(known: Observed, dt: float, lift_n: Vec3, gravity: float, v_n: Vec3) -> Vec3:
    """The velocity that a vehicle that stands still ought to have by now, from what is known of the forces on it;
    nothing once it moves, and one that was held is soon seen to move where it is pushed."""
    vx, vy, vz = v_n
    x, y, z = known.missing_n
    let_go = known.stuck and vx * x + vy * y + vz * z > LET_GO * math.sqrt(x * x + y * y + z * z)
    if let_go or vx * vx + vy * vy + vz * vz > STILL * STILL:
        return (0.0, 0.0, 0.0)
    (sx, sy, sz), kappa = known.slow_n, known.belief.kappa
    keep = 1.0 - dt / MISSING_TIME
    fx, fy, fz = lift_n
    return (
        keep * x + dt * (sx - kappa * fx),
        keep * y + dt * (sy - kappa * fy),
        keep * z + dt * (gravity + sz - kappa * fz),
    )


def _leapt(surprise: Surprise) -> bool:
    """Whether a measurement is no measurement of the motion that was believed in."""
    for axis, (miss, variance) in enumerate(zip(*surprise, strict=True)):
        if abs(miss) > (JUMP_P if axis < 3 else JUMP_V) and miss * miss > JUMP_SIGMAS**2 * variance:
            return True
    return False


def _bounded(belief: Belief, slow_n: Vec3, dt: float, flown: float) -> tuple[Belief, Vec3, bool]:
    """Everything within what a vehicle can be, the slow mean of the disturbance, and whether that met its edge."""
    dx, dy, dz = belief.disturbance_n
    sx, sy, sz = slow_n
    ox, oy, oz = dx - sx, dy - sy, dz - sz
    off = math.sqrt(ox * ox + oy * oy + oz * oz)
    share = flown / FIRST_FOR
    early = share < 1.0
    radius = FIRST_BALL + (BALL - FIRST_BALL) * share if early else BALL
    x = list(belief.x)
    held = off > radius
    if held:
        shrink = radius / off
        x[2], x[6], x[10] = sx + ox * shrink, sy + oy * shrink, sz + oz * shrink
    else:
        k = min(1.0, dt / (FIRST_SLOW_TIME if early else SLOW_TIME))
        slow_n = (sx + k * ox, sy + k * oy, sz + k * oz)
    x[KAPPA] = min(max(x[KAPPA], KAPPA_RANGE[0]), KAPPA_RANGE[1])
    x[DRAG] = min(max(x[DRAG], DRAG_RANGE[0]), DRAG_RANGE[1])
    return Belief(tuple(x), belief.P), slow_n, held


def _noise(noise: tuple[float, float], surprise: Surprise, dt: float) -> tuple[float, float]:
    """The variances of the measurements, drawn to where misses are as large as expected."""
    k = dt / (NOISE_TIME * 3.0)
    result = []
    for kind, first in enumerate((0, 3)):
        excess = 0.0
        for i in range(first, first + 3):
            miss, variance = surprise.innovation[i], surprise.variance[i]
            excess += min(miss * miss, 9.0 * variance) - variance
        result.append(min(max(noise[kind] + k * excess, NOISE_MIN[kind]), NOISE_MAX[kind]))
    return result[0], result[1]
