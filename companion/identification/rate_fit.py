"""The rate loops and what torque does, axis by axis.

    loop      L T w'' + L w' + w = G w_cmd + o      output error: the model is driven by the setpoint alone
    torque    tm (w'' + a w') + w' + a w = B tau + o

In a closed loop the gyro's noise is in the torque too, and regressing one on the other gives what is between the
controller and itself. So both are first projected on what the rate setpoint explains of them (two-stage least squares,
the instruments being the setpoint of the last second), which noise is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.identification.flight_data import SETTLING, STEP, Part, telling
from companion.identification.least_squares import Array, fit

BLOCK = 2.0
"""s over which residuals may err alike."""
INSTRUMENT_LAGS = np.arange(0.0, 1.2, 0.03)
"""s: how far back the rate setpoint is taken as an instrument; a yaw loop has died out by then."""
BAND = (0.15, 8.0)
"""Hz in which torque and turning are compared: below it offsets, above it vibration."""
LAG_RANGE, SECOND_RANGE, GAIN_RANGE = (0.005, 1.5), (0.002, 0.3), (0.5, 1.5)
"""s, s, 1: bounds of L, T, G."""
AUTHORITY_RANGE, MOTOR_LAG_RANGE, DAMPING_RANGE = (0.5, 2000.0), (0.002, 0.2), (-2.0, 5.0)
"""rad/s^2, s, 1/s: bounds of B, tm, a."""
TOLD_MIN = 3.0
"""s of telling flight from which on an axis is fitted. Engineering choice: BAND lets 16 independent samples a second
through, and less than 3 s of them are explained by 40 instruments whatever they are."""
STARTS = ((1.0, 0.07, 0.04, 0.0), (1.0, 0.07, 0.04, 0.0), (1.0, 0.4, 0.08, 0.0))
"""G, L (s), T (s), offset (rad/s) with which the search begins, roll, pitch, yaw (engineering choice: a usual loop)."""
MOTOR_LAG_START = 0.03
"""s with which the search for the motors' lag begins (engineering choice: 5 to 15 inches have 15 to 60 ms)."""
OFFSET = 2.0
"""rad/s or rad/s^2: bound of the offsets."""


class Found(NamedTuple):
    """A value and its standard deviation, which is infinite where the value was not found and only stands in for it."""

    value: float
    std: float

    @property
    def is_found(self) -> bool:
        """Whether the log says anything of it."""
        return math.isfinite(self.std)

    @property
    def relative(self) -> float:
        """The standard deviation over the value."""
        return abs(self.std / self.value) if self.value else float("inf")


NO_TORQUE = Found(1.0, math.inf), Found(MOTOR_LAG_START, math.inf)
"""rad/s^2 and s: authority and motor lag where neither was found."""


class AxisFit(NamedTuple):
    """One axis. ``gain``, ``lag`` s: G, L of the loop. ``authority``: B, rad/s^2 of a torque setpoint
    of 1. ``motor_lag``: s. ``excitation``: rad/s, the standard deviation of the setpoint. ``model``: rad/s, of each
    part, the loop's answer by the model; none where the loop was not found."""

    gain: Found
    lag: Found
    authority: Found
    motor_lag: Found
    excitation: float
    model: tuple[Array, ...]


def fit_axis(parts: Sequence[Part], axis: int, gyro_cutoff: float) -> AxisFit:
    """``axis``: 0 roll, 1 pitch, 2 yaw. ``gyro_cutoff``: Hz, of the gyro's low-pass (IMU_GYRO_CUTOFF), 0 for none."""
    blocks, settled = blocks_of(parts), [telling(part) for part in parts]
    commands = [part.rates_setpoint[:, axis] for part in parts]
    excitation = float(np.std(np.concatenate(commands)))
    start = STARTS[axis]
    if seconds(settled) < TOLD_MIN:
        return AxisFit(Found(start[0], math.inf), Found(start[1], math.inf), *NO_TORQUE, excitation, ())
    gyro = [part.gyro[:, axis] for part in parts]

    smooth = _low_pass(gyro_cutoff)

    def answered(theta: Array) -> list[Array]:
        gain, lag, second, offset = theta
        return [offset + smooth(_second_order(gain * command, lag, second)) for command in commands]

    def misses(theta: Array) -> Array:
        rows = zip(answered(theta), gyro, settled, strict=True)
        return np.concatenate([(model - seen)[kept] for model, seen, kept in rows])

    loop = fit(
        misses, np.concatenate([b[s] for b, s in zip(blocks, settled, strict=True)]), start,
        (GAIN_RANGE[0], LAG_RANGE[0], SECOND_RANGE[0], -OFFSET), (GAIN_RANGE[1], LAG_RANGE[1], SECOND_RANGE[1], OFFSET),
        (1.0, 0.1, 0.05, 0.1),
    )  # fmt: skip
    gain, lag = (Found(float(v), float(s)) for v, s in zip(loop.values[:2], loop.std[:2], strict=True))
    authority, motor_lag = _torque(parts, axis, gyro_cutoff, blocks, settled)
    return AxisFit(gain, lag, authority, motor_lag, excitation, tuple(answered(loop.values)))


def seconds(kept: Sequence[NDArray[np.bool_]]) -> float:
    """s of the flight that are kept."""
    return STEP * float(sum(np.count_nonzero(each) for each in kept))


def blocks_of(parts: Sequence[Part]) -> list[NDArray[np.int64]]:
    """Of each sample of each part, the number of its block."""
    found, first = [], 0
    for part in parts:
        block = first + ((part.t - part.t[0]) / BLOCK).astype(np.int64)
        found.append(block)
        first = int(block[-1]) + 1
    return found


def _torque(
    parts: Sequence[Part], axis: int, gyro_cutoff: float, blocks: list[NDArray[np.int64]],
    settled: list[NDArray[np.bool_]],
) -> tuple[Found, Found]:  # fmt: skip
    """B and tm."""
    from scipy.signal import butter, lfilter

    kept = [s & (part.t > part.t[0] + SETTLING + INSTRUMENT_LAGS[-1]) for part, s in zip(parts, settled, strict=True)]
    if seconds(kept) < TOLD_MIN:
        return NO_TORQUE
    band, smooth = butter(2, BAND, "bandpass", fs=1.0 / STEP), _low_pass(gyro_cutoff)
    rates = [lfilter(*band, part.gyro[:, axis]) for part in parts]
    # the gyro is late by its own low-pass: the torque is made as late
    torques = [lfilter(*band, smooth(part.torque[:, axis])) for part in parts]
    instruments = [_lagged(lfilter(*band, part.rates_setpoint[:, axis])) for part in parts]
    flat = np.concatenate([b[k] for b, k in zip(blocks, kept, strict=True)])

    def missing(theta: Array, turned: list[Array], twisted: list[Array]) -> Array:
        authority, lag, damping = theta
        rows = []
        for w, tau, k in zip(turned, twisted, kept, strict=True):
            rows.append((np.gradient(w, STEP) + damping * w - authority * first_order(tau, lag))[k])
        return np.concatenate(rows)

    explained = _projected(instruments, kept, rates), _projected(instruments, kept, torques)
    guess = _first_guess(*explained, kept)
    low, high = (
        (AUTHORITY_RANGE[0], MOTOR_LAG_RANGE[0], DAMPING_RANGE[0]),
        (AUTHORITY_RANGE[1], MOTOR_LAG_RANGE[1], DAMPING_RANGE[1]),
    )
    found = fit(
        lambda theta: missing(theta, *explained), flat, (guess, MOTOR_LAG_START, 0.0), low, high,
        (guess, MOTOR_LAG_START, 1.0),
        actual=lambda theta: missing(theta, rates, torques),
    )  # fmt: skip
    (b, tm, _), (b_std, tm_std, _) = found.values, found.std
    return Found(float(b), float(b_std)), Found(float(tm), float(tm_std))


def _first_guess(turned: list[Array], twisted: list[Array], kept: list[NDArray[np.bool_]]) -> float:
    """rad/s^2: the ratio of sizes."""
    turning = np.concatenate([np.gradient(w, STEP)[k] for w, k in zip(turned, kept, strict=True)])
    torque = np.concatenate([tau[k] for tau, k in zip(twisted, kept, strict=True)])
    return float(np.clip(np.std(turning) / max(np.std(torque), 1e-9), 1.0, 1000.0))


def _lagged(signal: Array) -> Array:
    """The instruments: one column a lag."""
    columns = []
    for lag in INSTRUMENT_LAGS:
        n = round(lag / STEP)
        columns.append(np.concatenate([np.zeros(n), signal[: len(signal) - n]]))
    return np.column_stack(columns)


def _projected(instruments: list[Array], kept: list[NDArray[np.bool_]], signals: list[Array]) -> list[Array]:
    """What the instruments explain of a signal."""
    Z = np.concatenate([z[k] for z, k in zip(instruments, kept, strict=True)])
    y = np.concatenate([s[k] for s, k in zip(signals, kept, strict=True)])
    weights = np.linalg.lstsq(Z, y, rcond=1e-6)[0]
    return [z @ weights for z in instruments]


def _low_pass(cutoff: float) -> Callable[[Array], Array]:
    """PX4's second-order Butterworth of its gyro, by which what is logged is late; 0: none."""
    from scipy.signal import butter, lfilter

    if not 0.0 < cutoff < 0.5 / STEP:
        return lambda signal: signal
    b, a = butter(2, cutoff, fs=1.0 / STEP)
    return lambda signal: signal[0] + np.asarray(lfilter(b, a, signal - signal[0]))


def first_order(signal: Array, lag: float, begin: float = 0.0) -> Array:
    """A signal that is constant over each step, lagged (s); ``begin``: at the first sample."""
    from scipy.signal import lfilter

    e = np.exp(-STEP / lag)
    filtered: Array = begin + lfilter([0.0, 1.0 - e], [1.0, -e], signal - begin)
    return filtered


def _second_order(signal: Array, lag: float, second: float) -> Array:
    """L T w'' + L w' + w = signal, from rest at the first sample."""
    from scipy.signal import cont2discrete, lfilter

    b, a, _ = cont2discrete(([1.0], [lag * second, lag, 1.0]), STEP, method="zoh")
    filtered: Array = signal[0] + lfilter(np.ravel(b), a, signal - signal[0])
    return filtered
