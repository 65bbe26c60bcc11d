"""A mission as a table: its path place by place, in its own coordinates, the local frame's and the earth's."""

from __future__ import annotations

import math
from collections.abc import Iterator

from companion.geodesy import LocalFrame
from companion.mission import Mission

COLUMNS = (
    "s_m", "time_s", "x_m", "y_m", "z_m", "north_m", "east_m", "down_m",
    "latitude_deg", "longitude_deg", "altitude_amsl_m", "speed_mps", "heading_deg", "curvature_per_m",
)  # fmt: skip
"""Distance along the path; time at the path's own speed, from its first row; the mission's coordinates; the local
frame's; the earth's; the speed with its sign; the heading clockwise from north; one over the radius."""


def rows_along(mission: Mission, home: LocalFrame, spacing: float) -> Iterator[tuple[float, ...]]:
    """The rows, ``spacing`` m apart at most, from end to end. ``mission``: placed in the local frame whose origin is
    ``home``, its speed known. ValueError, ArithmeticError: speed or yaw is not defined."""
    table = mission.table
    parts = max(1, math.ceil(table.length / spacing))
    step = table.length / parts
    time, slowness = 0.0, 0.0
    for i in range(parts + 1):
        s = table.length if i == parts else i * step
        p_n, _, bend = table.at(s)
        speed = mission.alpha(s)
        if i:
            time += 0.5 * step * (slowness + 1.0 / abs(speed))
        slowness = 1.0 / abs(speed)
        yield (
            s, time, *mission.placement.to_mission(p_n), *p_n, *home.to_global(p_n),
            speed, math.degrees(mission.beta(s)) % 360.0, math.hypot(*bend),
        )  # fmt: skip
