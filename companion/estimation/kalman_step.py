"""One step of the Kalman filter, recorded once and printed as straight-line floats. The model is in ``kalman``.

North, east and down have nothing in common but the thrust scale and the drag, q = (k, c): with these known the three
axes are three filters of their own. So the covariance is kept as

    S    of each axis, given q               x = x_0 + G (q - q_0) + e,  cov(e) = S
    G    of each axis, dx/dq
    T    of q

and of an axis as a whole it is S + G T G^T, between two axes G_i T G_j^T, with q G T. A measurement of an axis is taken
by that axis alone; what it says of q moves the others through their G, once, at the end of the step. That is a third of
the arithmetic of the whole matrix, and the same but for the noise of q: it loosens what an axis knows of q, which is
exact here, and with it (by under a thousandth in a step) what two axes have in common through q.

By the way it says how the state and the innovations go with parameters m of the thrust which are not in it, the motors'
lag and the thrust curve (see ``motor_lag``, ``thrust_curve``): y = dx/dm goes through the same step, driven by dF/dm in
the place of what is measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from companion.calculus import machine_code
from companion.calculus.scalar import Scalar
from companion.calculus.straight import Function, Packed, Tape
from companion.estimation.kalman_update import Axis, Matrix, Moved, update, update_frozen
from companion.estimation.translation import Scalar3, acceleration
from companion.frames import Vec3

PER_AXIS = 7
"""Number of states of each axis: P, V, U, B, D, W, E. By definition of the model."""
AXES = 3
"""Number of axes: north, east, down. By definition."""
POSITION, VELOCITY, WANDER, VELOCITY_ERROR, DISTURBANCE, GUST, HEADING_ERROR = range(PER_AXIS)
NORTH, EAST, DOWN = (PER_AXIS * axis for axis in range(AXES))
"""Index of the first state of each axis."""
THRUST_SCALE = AXES * PER_AXIS
"""Index of the thrust scale in the state. By definition."""
DRAG = THRUST_SCALE + 1
"""Index of the drag in the state. By definition."""
SIZE = THRUST_SCALE + 2
"""Number of states in all. By definition."""
PARAMETERS = ("lag", "curve")
"""The m that the state's sensitivities are told of, in their order. By definition of the model."""
UPPER = tuple((i, j) for i in range(PER_AXIS) for j in range(i, PER_AXIS))
"""The numbers of S of an axis: an upper triangle, row by row."""
AT = {pair: index for index, pair in enumerate(UPPER)}
DIAGONAL = tuple(len(UPPER) * axis + AT[i, i] for axis in range(AXES) for i in range(PER_AXIS))
"""Where the variance of each state, given q, stands in S."""
WANDER_TIME = 0.5
"""s, time constant of U. Spectrum of PX4's position error on a recorded circle, sensors shaking: that of its derivative
is flat to 0.3 Hz and falls from there."""
VELOCITY_ERROR_TIME = 3.5
"""s, time constant of B. Recorded in the same session: 3 to 4 s."""
GUST_TIME = 1.0
"""s, time constant of W. Engineering choice: 5 m of gust at 5 m/s."""
HEADING_ERROR_TIME = 4.0
"""s, time constant of E: the smooth heading error of a PX4 that shakes (two lags of 1.6 s in sih_noisy) has the power
below 0.1 Hz of one lag of 3.2 s. Recorded in the same session: 2 to 5.5 s."""
DISTURBANCE_TIME: Vec3 = (1e9, 1e9, 10.0)
"""s, time constant of D: the wind stays, a vertical push does not. Engineering choice."""
POSITION_Q = 1e-8
"""m^2/s, process noise of P beyond its wander: none but rounding. Engineering choice."""
VELOCITY_Q = 1e-4
"""m^2/s^3, process noise of V beyond D and W: the motors' noise. Engineering choice."""
THRUST_SCALE_Q = 1e-5
"""1/s, process noise of the thrust scale: 2.4 % in a minute, a battery that sags. Engineering choice."""
DRAG_Q = 1e-5
"""1/s^3, process noise of c: 0.024 1/s in a minute, a payload that turns, rotors that speed up. Engineering choice."""
POSITION_R_MIN = 3e-4**2
"""m^2, variance of the reported position, sample by sample. Recorded in the same session: 0.1 mm."""
POSITION_Q_GAIN = 24.0
"""1/s. A position that is noisier than that also wanders step by step: so many times the excess of its variance a
second is added to its process noise. Sweep over the worlds of configs/worlds."""
Rows = dict[int, list[tuple[int, Scalar]]]
"""Rows of an axis's transition that are not the identity's: state -> (state, factor)."""


def _record_step(name: str, *, learning: bool) -> Function:
    """``learning``: False freezes k and c; they move neither their axes nor their own covariance (Schmidt)."""
    tape = Tape()
    (dt,), F, (g,) = tape.inputs("dt"), tape.tuple_input("fx", "fy", "fz"), tape.inputs("g")
    measured = (*tape.tuple_input("xm", "ym", "zm"), *tape.tuple_input("vxm", "vym", "vzm"))
    noise_p, noise_v = tape.inputs("rp", "rv")
    levels = [tape.tuple_input(*(f"{kind}{axis}" for axis in "xyz")) for kind in ("u", "b", "w")]
    disturbance_q, (heading_error, tilt_error) = tape.tuple_input("qdx", "qdy", "qdz"), tape.inputs("e", "t")
    scale_q, drag_q = tape.inputs("qk", "qc")
    F_by_m = [tape.tuple_input(*(f"f{m}{axis}" for axis in "xyz")) for m in PARAMETERS]
    *states, (scale, c) = _inputs(tape, "x", SIZE, PER_AXIS)
    upper = _inputs(tape, "s", AXES * len(UPPER), len(UPPER), packed=True)
    slopes = _inputs(tape, "g", 2 * AXES * PER_AXIS, 2 * PER_AXIS, packed=True)
    tkk, tkc, tcc = tape.tuple_input("tkk", "tkc", "tcc")
    by_m = [tape.tuple_input(*(f"y{m}{i}" for i in range(SIZE)), packed=True) for m in PARAMETERS]
    T: Matrix = [[tkk, tkc], [tkc, tcc]]
    Q = (scale_q * dt, drag_q * dt)
    across: tuple[Scalar, ...] = (F[1] * -1.0, F[0], 0.0)  # e3 x F, by which E turns it
    f = [known - x[HEADING_ERROR] * turn for known, x, turn in zip(F, states, across, strict=True)]
    accelerations = acceleration(
        (scale * f[0], scale * f[1], scale * f[2]), _each(states, VELOCITY), g, c,
        _each([[*x, x[DISTURBANCE] + x[GUST]] for x in states], PER_AXIS),
    )  # fmt: skip
    # what a tilt error makes of a thrust that leans is vertical
    lifting = (F[0] * F[0] + F[1] * F[1]) * tilt_error * (2.0 / DISTURBANCE_TIME[AXES - 1])
    axes = []
    for axis, (x, S, G) in enumerate(zip(states, upper, slopes, strict=True)):
        u, b, w = (level[axis] for level in levels)
        noises = (
            POSITION_Q + (noise_p - POSITION_R_MIN) * POSITION_Q_GAIN, VELOCITY_Q, u * (2.0 / WANDER_TIME),
            b * (2.0 / VELOCITY_ERROR_TIME), disturbance_q[axis] + (lifting if axis == AXES - 1 else 0.0),
            w * (2.0 / GUST_TIME), heading_error * (2.0 / HEADING_ERROR_TIME),
        )  # fmt: skip
        rows, by_q = _transition(axis, dt, c, scale * across[axis]), (f[axis], x[VELOCITY])
        a_by_m = [_driven(by_q, y, scale * F_by[axis]) for y, F_by in zip(by_m, F_by_m, strict=True)]
        y = [column[PER_AXIS * axis : PER_AXIS * (axis + 1)] for column in by_m]
        known = _predict(_as_axis(x, S, G, y), rows, dt, accelerations[axis], a_by_m, by_q)
        for i, noise in enumerate(noises):
            known.S[i][i] = known.S[i][i] + noise * dt
        axes.append(_loosen(known, T, Q) if learning else known)
    if learning:
        T = [[tkk + Q[0], tkc], [tkc, tcc + Q[1]]]
    moved: Moved = [[0.0, 0.0] for _ in range(1 + len(PARAMETERS))]
    take = update if learning else update_frozen
    positions = [take(known, T, moved, (POSITION,), measured[i], noise_p) for i, known in enumerate(axes)]
    both = (VELOCITY, VELOCITY_ERROR)
    velocities = [take(known, T, moved, both, measured[AXES + i], noise_v) for i, known in enumerate(axes)]
    (by_k, by_c), *y_by_q = moved
    x = [value + (k * by_k + d * by_c) for known in axes for value, (k, d) in zip(known.x, known.G, strict=True)]
    return machine_code.function_of(tape, name, [
        [*x, scale + by_k, c + by_c],
        Packed(known.S[i][j] for known in axes for i, j in UPPER),
        Packed(slope for known in axes for row in known.G for slope in row),
        [T[0][0], T[0][1], T[1][1]],
        *(Packed(_column(axes, m, by_m[m][THRUST_SCALE:], by)) for m, by in enumerate(y_by_q)),
        *([each[kind] for each in (*positions, *velocities)] for kind in range(2 + len(PARAMETERS))),
    ])  # fmt: skip


def _inputs(tape: Tape, name: str, count: int, size: int, *, packed: bool = False) -> list[Sequence[Scalar]]:
    """``count`` numbers, so many of each axis; at the end those of none."""
    numbers = tape.tuple_input(*(f"{name}{i}" for i in range(count)), packed=packed)
    return [numbers[at : at + size] for at in range(0, count, size)]


def _each(states: Sequence[Sequence[Scalar]], kind: int) -> Scalar3:
    """One number of each axis."""
    x, y, z = (state[kind] for state in states)
    return x, y, z


def _driven(by_q: tuple[Scalar, Scalar], y: Sequence[Scalar], by_thrust: Scalar) -> Scalar:
    """The acceleration of an axis over a parameter: by q, which goes with it as ``y`` says, and by the thrust."""
    return (by_q[0] * y[THRUST_SCALE] + by_q[1] * y[DRAG] + by_thrust) * -1.0


def _column(axes: list[Axis], m: int, of_q: Sequence[Scalar], moved: list[Scalar]) -> list[Scalar]:
    """The sensitivity of the whole state to parameter ``m``. ``of_q``: of q before the step, which has ``moved``."""
    (by_k, by_c), (k, c) = moved, of_q
    axis = [value + (g * by_k + d * by_c) for each in axes for value, (g, d) in zip(each.y[m], each.G, strict=True)]
    return [*axis, k + by_k, c + by_c]


def _as_axis(
    x: Sequence[Scalar], upper: Sequence[Scalar], slopes: Sequence[Scalar], y: Sequence[Sequence[Scalar]]
) -> Axis:
    S = [[upper[AT[min(i, j), max(i, j)]] for j in range(PER_AXIS)] for i in range(PER_AXIS)]
    return Axis(list(x), S, [list(slopes[2 * i : 2 * i + 2]) for i in range(PER_AXIS)], list(map(list, y)))


def _transition(axis: int, dt: Scalar, c: Scalar, across: Scalar) -> Rows:
    """Of the deviations over ``dt`` s: each lag exactly in its decay to first order. ``across``: m/s^2 for a radian of
    E."""
    rows = Rows()
    rows[POSITION] = [(POSITION, 1.0), (VELOCITY, dt), (WANDER, dt)]
    rows[VELOCITY] = [(VELOCITY, 1.0 - dt * c), (DISTURBANCE, dt), (GUST, dt), (HEADING_ERROR, dt * across)]
    lags = {
        WANDER: WANDER_TIME, VELOCITY_ERROR: VELOCITY_ERROR_TIME, DISTURBANCE: DISTURBANCE_TIME[axis], GUST: GUST_TIME,
        HEADING_ERROR: HEADING_ERROR_TIME,
    }  # fmt: skip
    for i, time in lags.items():
        if time < 1e6:
            rows[i] = [(i, 1.0 / (1.0 + dt * (1.0 / time)))]  # positive at any step
    return rows


def _predict(
    known: Axis, rows: Rows, dt: Scalar, a: Scalar, a_by_m: Sequence[Scalar], by_q: tuple[Scalar, Scalar]
) -> Axis:
    """``dt`` s later: the state, P to second order; A S A^T; A G + B; A y + b. ``a``: m/s^2; ``a_by_m``: that over each
    of m; ``by_q``: what k and c take from it, each over its unit."""
    x, S, G, y = known
    later = [x[i] * rows[i][0][1] if i in rows else x[i] for i in range(PER_AXIS)]
    later[POSITION] = x[POSITION] + dt * (x[VELOCITY] + x[WANDER]) + (dt * dt * 0.5) * a
    later[VELOCITY] = x[VELOCITY] + dt * a
    half = [[_combined(rows, i, [S[k][j] for k in range(PER_AXIS)]) for j in range(PER_AXIS)] for i in range(PER_AXIS)]
    spread: Matrix = [[0.0] * PER_AXIS for _ in range(PER_AXIS)]
    for i, j in UPPER:
        spread[i][j] = spread[j][i] = _combined(rows, j, half[i])
    slopes = [[_combined(rows, i, [row[k] for row in G]) for k in (0, 1)] for i in range(PER_AXIS)]
    slopes[VELOCITY] = [slope - dt * by for slope, by in zip(slopes[VELOCITY], by_q, strict=True)]
    by_m = [[_combined(rows, i, column) for i in range(PER_AXIS)] for column in y]
    for column, a_by in zip(by_m, a_by_m, strict=True):
        column[VELOCITY] = column[VELOCITY] + dt * a_by
    return Axis(later, spread, slopes, by_m)


def _combined(rows: Rows, i: int, of: list[Scalar]) -> Scalar:
    """Row ``i`` of the transition times a column."""
    if i not in rows:
        return of[i]
    total: Scalar = 0.0
    for column, factor in rows[i]:
        total = total + of[column] * factor
    return total


def _loosen(known: Axis, T: Matrix, Q: tuple[Scalar, Scalar]) -> Axis:
    """Once q has moved by noise of the variances ``Q``: what of the axis went with q before goes less with it now,

    G' = G M,  S' = S + G M Q G^T,  M = T (T + Q)^-1, so that S + G T G^T and G T stay what they were."""
    x, S, G, y = known
    (tkk, tkc), (_, tcc) = T
    inverse = 1.0 / ((tkk + Q[0]) * (tcc + Q[1]) - tkc * tkc)
    M = (
        (1.0 - Q[0] * (tcc + Q[1]) * inverse, tkc * Q[0] * inverse),
        (tkc * Q[1] * inverse, 1.0 - Q[1] * (tkk + Q[0]) * inverse),
    )
    slopes = [[k * M[0][0] + c * M[1][0], k * M[0][1] + c * M[1][1]] for k, c in G]
    for i, j in UPPER:
        S[i][j] = S[j][i] = S[i][j] + (slopes[i][0] * Q[0] * G[j][0] + slopes[i][1] * Q[1] * G[j][1])
    return Axis(x, S, slopes, y)


@lru_cache(maxsize=4)
def step_of(learning: bool, in_machine_code: bool) -> Function:
    """(dt, F, g, p_n, v_n, *NoiseLevels, noise of k and c, dF/dm, *Belief) -> (*Belief, innovations, variances, how
    they go with m). ``learning``: False freezes k and c. ``in_machine_code``: whether that is in use."""
    return _record_step("kalman" if learning else "kalman_frozen", learning=learning)


for _learning in (True, False):
    step_of(_learning, machine_code.in_use)  # recorded now and not in a flight's first tick
