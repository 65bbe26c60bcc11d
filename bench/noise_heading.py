"""The heading in the linear world of ``bench.noise_world``, beside a path that is held by our law.

    psi' = r + s q        theta T r'' + T r' + r = u        reported: psi and its error

q: the rate of the tilt that holds the path, noise and all, which a thrust that leans projects on the heading by s (root
of its mean square over all directions of the nose, as the error of the reported tilt is); u: the yaw rate commanded.
The controller has the gyro, q and the command that q follows.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import block_diag

from bench.noise_flown import flown
from bench.noise_world import STEP, Place, Plant, attitude_deviations, axis_at, delayed, discrete, smooth
from companion.config.world.world import load_world
from companion.vehicle import GRAVITY as G
from companion.vehicle import Vehicle

YAW_LAG = 0.36
"""s, of PX4's yaw loop on its simulated quadrotor. Identified in flights on sih."""
TORQUE_LAG = 0.12
"""s, of its torque: PX4's filter on it (MC_YAW_TQ_CUTOFF 2 Hz) and the motors."""


def heading_plant(place: Place, vehicle: Vehicle, poles: tuple[complex, ...]) -> Plant:
    """``poles``: 1/s, of the level distance to the path."""
    path = axis_at(place, vehicle)
    loop = flown(path, vehicle, poles)
    assert loop is not None
    errors = load_world("sih_noisy").estimate
    tilt, heading = attitude_deviations()
    projected = place.lean / G / math.sqrt(2.0)
    own, noise = smooth(math.hypot(heading, projected * tilt), errors.attitude.wander_time)
    A, B, W = np.zeros((5, 5)), np.zeros((5, 2)), np.zeros((5, 5))
    A[0, 1] = A[1, 2] = 1.0
    A[2, 1], A[2, 2] = -1.0 / (YAW_LAG * TORQUE_LAG), -1.0 / TORQUE_LAG
    B[2, 0], B[0, 1] = 1.0 / (YAW_LAG * TORQUE_LAG), projected
    A[3:, 3:], W[3:, 3:] = own, noise
    Ad, Bd, Wd = discrete(A, B, W, STEP)
    n = len(loop.F)
    whole = block_diag(Ad, loop.F)
    whole[:5, 5 + 3] = Bd[:, 1]  # q, the fourth state of the axis across the path
    C = np.zeros((4, 5 + n))
    C[0, [0, 4]] = C[1, 1] = C[2, 5 + 3] = C[3, 5 + len(path.A) - 1] = 1.0
    white = (errors.attitude.white[2], errors.gyro.white[2], errors.gyro.white[0], 1e-4)
    return delayed(
        Plant(
            whole,
            np.vstack([Bd[:, :1], np.zeros((n, 1))]),
            block_diag(Wd, loop.driven),
            C,
            np.diag(np.square(white)),
            C[0],
        )
    )
