"""The offset of two clocks, by the body rates that both sides hold: where their cross-correlation is greatest.

PX4 stamps ODOMETRY with the clock that it writes its log with, so the offset is zero unless something between rewrote
the stamps; a peak there is preferred, because a vehicle that circles repeats itself.

    rho(d) = sum a(t + d) . b(t) / sqrt(sum |a(t + d)|^2  sum |b(t)|^2)        over the times that both have
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRID = 0.01
"""s: both are brought to it; the peak is found finer, by a parabola (engineering choice)."""
OVERLAP_MIN = 3.0
"""s that both must have in common (engineering choice)."""
SAME_CLOCK = 0.1
"""s about zero within which a peak means that the clocks are one (engineering choice)."""
ONE_CLOCK = 0.5 * GRID
"""s: an offset below it is an error of this estimate, and the clocks are one: of PX4's own log it is -0.4 ms, and there
the place at a stamp is the one received with that stamp, to the last digit (tests/data/px4_flight.ulg)."""
NEARLY_BEST = 0.9
"""of the best correlation: a peak at zero that reaches it is taken before all others (engineering choice)."""
CORRELATION_MIN = 0.6
"""Two flights of one path on another day stay below; of one flight it is 0.95 and more (tests/record/test_ulog.py)."""


class Alignment(NamedTuple):
    """``offset``: s, our stamp less the log's of the same moment. ``correlation``: of the body rates there, 1 at best.
    ``overlap``: s that both have."""

    offset: float
    correlation: float
    overlap: float


def alignment(t_ours: Array, ours: Array, t_log: Array, log: Array) -> Alignment | None:
    """Of body rates (n, 3), rad/s, at rising times, s. None: too little in common, or they do not match."""
    if len(t_ours) < 2 or len(t_log) < 2:
        return None
    begin_ours, a, begin_log, b = float(t_ours[0]), _on_grid(t_ours, ours), float(t_log[0]), _on_grid(t_log, log)
    rho, overlap = _correlations(a, b)
    rho[overlap * GRID < OVERLAP_MIN] = -1.0
    lags = np.arange(len(rho)) - (len(b) - 1)
    offsets = begin_ours - begin_log + lags * GRID
    best = int(np.argmax(rho))
    near = np.flatnonzero(np.abs(offsets) <= SAME_CLOCK)
    if len(near):
        nearest = int(near[np.argmax(rho[near])])
        if rho[nearest] >= NEARLY_BEST * rho[best]:
            best = nearest
    if rho[best] < CORRELATION_MIN:
        return None
    offset = float(offsets[best] + GRID * _peak(rho, best))
    return Alignment(0.0 if abs(offset) < ONE_CLOCK else offset, float(rho[best]), float(overlap[best] * GRID))


def _on_grid(t: Array, values: Array) -> Array:
    """(m, 3), one row every GRID s, less the mean."""
    at = np.arange(t[0], t[-1], GRID)
    rows = np.column_stack([np.interp(at, t, column) for column in values.T])
    return np.asarray(rows - rows.mean(axis=0), dtype=float)


def _correlations(a: Array, b: Array) -> tuple[Array, Array]:
    """rho of every lag -(len(b) - 1) .. len(a) - 1, and how many rows both have there."""
    n = len(a) + len(b) - 1
    size = 1 << (n - 1).bit_length()

    def correlated(x: Array, y: Array) -> Array:
        product = np.fft.rfft(x, size) * np.conj(np.fft.rfft(y, size))
        return np.asarray(np.roll(np.fft.irfft(product, size), len(b) - 1)[:n], dtype=float)

    there_a, there_b = np.ones(len(a)), np.ones(len(b))
    along = sum((correlated(a[:, i], b[:, i]) for i in range(3)), np.zeros(n))
    energy_a = correlated((a * a).sum(axis=1), there_b)
    energy_b = correlated(there_a, (b * b).sum(axis=1))
    floor = 1e-9 * max(float((a * a).sum()), float((b * b).sum()), 1e-12)
    rho = along / np.sqrt(np.maximum(energy_a, floor) * np.maximum(energy_b, floor))
    return rho, np.round(correlated(there_a, there_b))


def _peak(rho: Array, at: int) -> float:
    """The top of the parabola through a peak and its neighbours, in steps from it, -0.5 .. 0.5."""
    if not 0 < at < len(rho) - 1:
        return 0.0
    before, here, after = (float(rho[at + i]) for i in (-1, 0, 1))
    bend = before - 2.0 * here + after
    return 0.0 if bend >= 0.0 else max(-0.5, min(0.5, 0.5 * (before - after) / bend))
