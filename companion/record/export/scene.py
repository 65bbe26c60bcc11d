"""What a 3-D view draws: poses, the path and what was flown as lines, the vehicle as a cross.

Viewers count z up, so positions go out as (east, north, up) in the frame ``local`` and bodies as forward, left, up in
the frame ``vehicle``; q_enu_flu = q_enu_ned * q_ned_frd * q_frd_flu.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from companion.record.export.columns import Array
from companion.record.export.schemas import SHAPES

WORLD, BODY = "local", "vehicle"
PATH_COLOR, FLOWN_COLOR, BODY_COLOR = (0.0, 0.45, 0.7, 1.0), (0.9, 0.6, 0.0, 1.0), (0.8, 0.2, 0.2, 1.0)
LINE_STRIP, LINE_LIST = 0, 2
"""Of foxglove.LinePrimitive.type."""
WIDTH = 2.0
"""Pixels."""
ARM = 0.35
"""m, half of the drawn vehicle's size (engineering choice)."""
HALF = float(np.sqrt(0.5))


def enu(points: Array) -> Array:
    """(n, 3) north, east, down -> east, north, up."""
    return np.column_stack([points[:, 1], points[:, 0], -points[:, 2]])


def enu_flu(q: Array) -> Array:
    """Quaternions (n, 4) wxyz, FRD to NED -> x, y, z, w, FLU to ENU.

    (0, h, h, 0) * q * (0, 1, 0, 0) with h = sqrt(1/2), written out, and its sign turned.
    """
    w, x, y, z = q.T
    return HALF * np.column_stack([x + y, x - y, w - z, w + z])


def stamp(nanoseconds: int) -> str:
    """A time as JSON."""
    return f'{{"sec":{nanoseconds // 1_000_000_000},"nsec":{nanoseconds % 1_000_000_000}}}'


def pose_columns(points: Array, quaternions: Array) -> list[Array]:
    """The numbers of poses: ``points`` (n, 3) NED, ``quaternions`` (n, 4) wxyz FRD to NED."""
    return [*enu(points).T, *enu_flu(quaternions).T]


def pose_parts(position: str, orientation: str, before: str, behind: str) -> list[str]:
    """What stands around the numbers of a pose as JSON, under these names."""
    x, *yz = (f',"{axis}":' for axis in "xyz")
    a, *bcd = (f',"{axis}":' for axis in "xyzw")
    return [f'{before}"{position}":{{{x[1:]}', *yz, f'}},"{orientation}":{{{a[1:]}', *bcd, "}" + behind]


def line_scene(name: str, points: Array, color: tuple[float, ...], at: int) -> bytes:
    """A line through ``points`` (n, 3) NED that stays."""
    return _scene(name, WORLD, _line(enu(points), LINE_STRIP, color), at)


def vehicle_scene(at: int) -> bytes:
    """A cross with a nose that moves with the vehicle."""
    a = ARM
    points = np.array([[a, a, 0], [-a, -a, 0], [a, -a, 0], [-a, a, 0], [0, 0, 0], [1.5 * a, 0, 0]], dtype=float)
    return _scene("vehicle", BODY, _line(points, LINE_LIST, BODY_COLOR), at)


def _line(points: Array, kind: int, color: tuple[float, ...]) -> dict[str, Any]:
    return {
        "type": kind,
        "pose": {"position": {"x": 0, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}},
        "thickness": WIDTH,
        "scale_invariant": True,
        "points": [{"x": x, "y": y, "z": z} for x, y, z in np.round(points, 4).tolist()],
        "color": dict(zip("rgba", color, strict=True)),
        "colors": [],
        "indices": [],
    }


def _scene(name: str, frame: str, line: dict[str, Any], at: int) -> bytes:
    entity = {
        "timestamp": json.loads(stamp(at)),
        "frame_id": frame,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **{shape: [line] if shape == "lines" else [] for shape in SHAPES},
    }
    return json.dumps({"deletions": [], "entities": [entity]}, separators=(",", ":")).encode()
