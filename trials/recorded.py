"""A recorded session of a real PX4 with the truth beside it, worked through by the estimator again: NEES and NIS.

What PX4 flew at the level of rates its ATTITUDE_TARGET does not show; the thrust that acted is taken from the truth:
F = g e3 - a - c v along the true thrust axis, over the true thrust scale.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from companion.estimation.estimator import Measurement, Prior, initial_estimator_state, update_estimate
from companion.frames import Quaternion, Vec3, body_z_axis, rotation_matrix
from companion.vehicle import VehicleState
from trials.consistency import AHEAD, Window, errors, leaning, windows
from trials.measured import machine
from trials.prediction import Forecast

TRUE_SCALE = 1.02
"""Thrust made over thrust commanded of PX4's simulated quadrotor: 0.5 / 0.4905."""
SMOOTHED = 7
"""samples of the true velocity that make its derivative: 56 ms."""


class Session(NamedTuple):
    """What the estimator made of it. ``nis``, ``nis_second``: as of a trial."""

    windows: tuple[Window, ...]
    nis: tuple[float, ...]
    nis_second: tuple[float, ...]


def session(file: Path, engaged: float, followed: float, ended: float) -> Session:
    """``file``: arrays odom and truth (../shared/data/px4_noisy.md). s on its clock: the hand-over to the companion,
    the beginning and the end of following."""
    with np.load(file) as data:
        odom, truth = data["odom"], data["truth"]
    drag, g = machine("sih").drag, machine("sih").gravity
    step = float(np.median(np.diff(odom[:, 0])))
    a = savgol_filter(truth[:, 4:7], SMOOTHED, 2, deriv=1, delta=step, axis=0)
    axes = np.array([body_z_axis(_quaternion(row)) for row in truth])
    thrust = (((0.0, 0.0, g) - a - drag * truth[:, 4:7]) * axes).sum(axis=1)
    chosen = np.flatnonzero((odom[:, 0] >= engaged) & (odom[:, 0] <= ended))
    first = _state(odom[chosen[0]])
    known = initial_estimator_state(first.p_n, first.v_n, rotation_matrix(first.q_nb), g, Prior())
    forecasts = Forecast(0.0, g), Forecast(AHEAD, g)
    rows: list[tuple[float, ...]] = []
    for i in chosen[1:]:
        before, now = _state(odom[i - 1]), _state(odom[i])
        if now.t_boot <= before.t_boot:
            continue
        f = 0.5 * (thrust[i] + thrust[i - 1]) / TRUE_SCALE
        x, y, z = 0.5 * f * np.add(before.z_axis_n, now.z_axis_n)
        measured = Measurement(
            now.t_boot - before.t_boot, (float(x), float(y), float(z)), now.p_n, now.v_n, moving=True
        )
        known = update_estimate(known, measured, g)
        if now.t_boot < followed:
            continue
        for forecast in forecasts:
            forecast.take(now, float(thrust[i]) / TRUE_SCALE, known)
        pushed = np.multiply(thrust[i], leaning(_quaternion(truth[i]), now.q_nb))
        rows.append((now.t_boot - followed, *errors(known.belief, TRUE_SCALE, drag, pushed)))
    nis, nis_second = (tuple(value for _, value in forecast.found) for forecast in forecasts)
    return Session(windows(np.array(rows)), nis, nis_second)


def _quaternion(row: NDArray[np.float64]) -> Quaternion:
    w, x, y, z = map(float, row[7:11])
    return (w, x, y, z)


def _state(row: NDArray[np.float64]) -> VehicleState:
    t, *numbers = map(float, row)
    p_n: Vec3 = (numbers[0], numbers[1], numbers[2])
    return VehicleState(
        t, p_n, (numbers[3], numbers[4], numbers[5]), _quaternion(row), (numbers[10], numbers[11], numbers[12])
    )
