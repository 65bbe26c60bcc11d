"""Tables over arc length, as missions write them: speeds in m/s, headings in degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.frames import wrap
from companion.profiles.over_arc import interpolated
from companion.profiles.speed import SpeedProfile
from companion.profiles.yaw import YawProfile

Table = Sequence[tuple[float, float]]


def speed_table(table: Table, period: float | None) -> SpeedProfile:
    """A speed through the samples (s in m, speed in m/s). ``period``: the length of a closed path."""
    s, speeds = _samples(table, period)
    return SpeedProfile(interpolated(s, speeds, period))


def yaw_table(table: Table, period: float | None) -> YawProfile:
    """A heading through the samples (s in m, heading in rad), from each to the next the short way round."""
    s, headings = _samples(table, period)
    unwrapped = [headings[0]]
    for heading in headings[1:]:
        unwrapped.append(unwrapped[-1] + wrap(heading - unwrapped[-1]))
    gain = 0.0
    if period is not None:
        gain = math.tau * round((unwrapped[-1] + wrap(headings[0] - unwrapped[-1]) - headings[0]) / math.tau)
    return YawProfile(interpolated(s, unwrapped, period, gain))


def _samples(table: Table, period: float | None) -> tuple[list[float], list[float]]:
    """The columns; of a closed path's table without a last sample that is its first again."""
    rows = list(table)
    if period is not None and len(rows) > 1 and rows[-1][0] - rows[0][0] >= period * (1.0 - 1e-9):
        rows.pop()
    return [s for s, _ in rows], [value for _, value in rows]
