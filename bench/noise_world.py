"""sih_noisy as a linear world, one axis at a time, for ``bench.noise_floor``: in steps of 8 ms

    x' = A x + B u + noise W,  y = C x + noise R,  e = E x

x: distance, its rate, tilt (or thrust) behind the rate loop (or the motors), and the errors of what is reported, which
are driven processes; u: the command, which acts one step later: at motors the angular acceleration, or the thrust. The
attitude's errors decay after the boot: here they have their mean variance over the time that is judged, 10 to 40 s of
following. Their bias is constant, so that a controller that integrates knows it: it is no part of the floor.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from companion.config.world.world import load_world
from companion.vehicle import GRAVITY as G
from companion.vehicle import Vehicle

Array = NDArray[np.float64]

STEP = 0.008
"""s: states come and setpoints go at 125 Hz, and a setpoint acts one step later."""
JUDGED = (10.7, 40.7)
"""s since the boot: 10 to 40 s of following, which begins 0.7 s after it."""
ROUND_OFF = 1e-5
"""m: a reported position has no noise of its own; the filter's equation wants some."""
DRAG = 1.0
"""1/s, of the vehicle."""
DAMPING = 1.0
"""1/s, of its turning (SIH_KDW), found in flight."""
STATES = 5
"""Number of states of an axis before its errors: distance, rate, tilt, and two of the rate loop."""


class Plant(NamedTuple):
    """One axis. ``A``, ``B``: of the step; ``W``: noise of the state; ``C``, ``R``: of the measurements position,
    velocity, tilt (or thrust), gyro; ``e``: the row that reports the distance, or the speed along the path."""

    A: Array
    B: Array
    W: Array
    C: Array
    R: Array
    e: Array


class Place(NamedTuple):
    """Of a path. ``inward``, ``forward``: m/s^2 of level thrust over mass, across the path and along it. ``turning``:
    rad/s of the direction of flight."""

    inward: float
    forward: float
    turning: float

    @property
    def lean(self) -> float:
        """m/s^2 of level thrust over mass."""
        return math.hypot(self.inward, self.forward)


def smooth(sigma: float, time: float) -> tuple[Array, Array]:
    """Two equal lags (A, noise density) of which the second has ``sigma``."""
    A = np.array([[-1.0 / time, 0.0], [1.0 / time, -1.0 / time]])
    return A, np.diag([4.0 * sigma**2 / time, 0.0])


def _turned(process: tuple[Array, Array], turning: float) -> tuple[Array, Array]:
    """Two equal processes, north and east, seen from a frame that turns (rad/s): (across, along) of each state."""
    A, W = process
    return np.kron(A, np.eye(2)) - turning * np.kron(np.eye(len(A)), [[0.0, -1.0], [1.0, 0.0]]), np.kron(W, np.eye(2))


def attitude_deviations() -> tuple[float, float]:
    """rad, of tilt and heading as reported: root of the mean variance over JUDGED."""
    attitude = load_world("sih_noisy").estimate.attitude
    assert attitude.start is not None
    times = np.linspace(*JUDGED, 301)
    left = np.exp(-times / attitude.start_time)
    tilt, heading = (
        math.sqrt(np.mean((stays + (first - stays) * left) ** 2))
        for stays, first in zip(attitude.wander[1:], attitude.start[1:], strict=True)
    )
    return tilt, heading


def discrete(A: Array, B: Array, W: Array, step: float) -> tuple[Array, Array, Array]:
    """Van Loan: the exact step of x' = A x + B u + noise of density W."""
    n, m = B.shape
    held = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * step)
    both = expm(np.block([[-A, W], [np.zeros((n, n)), A.T]]) * step)
    return held[:n, :n], held[:n, n:], both[n:, n:].T @ both[:n, n:]


def delayed(plant: Plant) -> Plant:
    """A command acts one step later: it is a state."""
    n = len(plant.A)
    A = np.block([[plant.A, plant.B], [np.zeros((1, n + 1))]])
    B = np.vstack([np.zeros((n, 1)), [[1.0]]])
    W = np.block([[plant.W, np.zeros((n, 1))], [np.zeros((1, n + 1))]])
    wider = np.zeros((len(plant.C), 1))
    return plant._replace(A=A, B=B, W=W, C=np.hstack([plant.C, wider]), e=np.append(plant.e, 0.0))


def axis_at(
    place: Place, vehicle: Vehicle, *, vertical: bool = False, along: bool = False, gain: float = 1.0,
    at_motors: bool = False,
) -> Plant:  # fmt: skip
    """An axis at a place of a path: across it, along it (then e is the speed), or vertical. Level: body rate -> tilt ->
    acceleration; vertical: rate of the thrust, of which the motors make ``gain`` times what is asked for.
    ``at_motors``: level angular acceleration -> motors -> body rate, damped; vertical the thrust itself."""
    errors = load_world("sih_noisy").estimate
    attitude, axis = errors.attitude, 2 if vertical else 0
    tilt, heading = attitude_deviations()
    assert errors.drift is not None
    parts = [
        smooth(errors.position.wander[axis], errors.position.wander_time),
        smooth(errors.drift.speed[axis] * errors.drift.time, errors.drift.time),
        smooth(errors.velocity.wander[axis], errors.velocity.wander_time),
        _turned(smooth(tilt, attitude.wander_time), place.turning) if vertical else smooth(tilt, attitude.wander_time),
        smooth(heading, attitude.wander_time),
    ]
    starts = np.cumsum([STATES, *(len(own) for own, _ in parts)])
    n = int(starts[-1])
    A, B, W = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((n, n))
    for at, (own, noise) in zip(starts, parts, strict=False):
        here = slice(at, at + len(own))
        A[here, here], W[here, here] = own, noise
    position, drift, velocity, tilts, turns = (int(start) + 1 for start in starts[:-1])
    A[0, 1], A[1, 1], A[1, 2] = 1.0, -DRAG, G if not vertical else 1.0
    if vertical:  # a tilt that is not what it is held to be lifts a thrust that leans: the two of the second state
        A[1, tilts + 1], A[1, tilts + 2] = -place.forward, place.inward
        A[2, 2], A[2, 3], B[3, 0] = -1.0 / vehicle.motor_lag, gain / vehicle.motor_lag, 1.0
        A[4, 4] = -1.0 / vehicle.motor_lag
        if at_motors:  # the law integrates it: the fourth state stands idle
            A[2, 3], B[2, 0], A[3, 3], B[3, 0] = 0.0, A[2, 3], -1.0 / vehicle.motor_lag, 0.0
    else:  # and a heading that is not turns it
        A[1, tilts], A[1, turns] = -G, place.inward if along else place.forward
        decay, stiff = 1.0 / vehicle.motor_lag, 1.0 / (vehicle.rate_loop_lag * vehicle.motor_lag)
        A[2, 3], A[3, 4], A[4, 3], A[4, 4], B[4, 0] = 1.0, 1.0, -stiff, -decay, stiff
        if at_motors:
            A[3, 3], A[4, 3], B[4, 0] = -DAMPING, 0.0, decay
        else:  # its rate loop flies by that gyro
            W[4, 4] = stiff**2 * errors.gyro.white[0] ** 2 * 0.5 * STEP
    C = np.zeros((4, n))
    C[0, [0, position, drift]], C[1, [1, velocity]], C[3, 3] = 1.0, 1.0, 1.0
    C[2, [2] if vertical else [2, tilts]] = 1.0
    white = (ROUND_OFF, errors.velocity.white[axis], attitude.white[0], errors.gyro.white[0])
    R = np.diag(np.square((*white[:2], 1e-3, 1e-3) if vertical else white))
    e = C[0] @ A if along else C[0]
    return delayed(Plant(*discrete(A, B, W, STEP), C, R, e))
