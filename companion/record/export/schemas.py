"""JSON schemas: of a named series, and of those of Foxglove's well-known schemas that the file uses.

Foxglove knows its own by their names and draws them; PlotJuggler makes a curve of every number.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

Schema = dict[str, Any]


class Field(NamedTuple):
    """One quantity of a series: ``name``, ``unit`` (SI, or deg), ``meaning``."""

    name: str
    unit: str
    meaning: str


def _object(title: str, properties: Schema) -> Schema:
    return {"title": title, "type": "object", "properties": properties}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


_WHOLE: Schema = {"type": "integer"}
_NUMBER: Schema = {"type": "number"}
_TEXT: Schema = {"type": "string"}
TIME = _object("time", {"sec": _WHOLE, "nsec": _WHOLE})
POINT = _object("foxglove.Point3", {axis: {"type": "number", "unit": "m"} for axis in "xyz"})
VECTOR = _object("foxglove.Vector3", {axis: {"type": "number", "unit": "m"} for axis in "xyz"})
QUATERNION = _object("foxglove.Quaternion", dict.fromkeys("xyzw", _NUMBER))
COLOR = _object("foxglove.Color", dict.fromkeys("rgba", _NUMBER))
POSE = _object("foxglove.Pose", {"position": POINT, "orientation": QUATERNION})
LINE = _object(
    "foxglove.LinePrimitive",
    {
        "type": _WHOLE,
        "pose": POSE,
        "thickness": _NUMBER,
        "scale_invariant": {"type": "boolean"},
        "points": _list(POINT),
        "color": COLOR,
        "colors": _list(COLOR),
        "indices": _list(_WHOLE),
    },
)
SHAPES = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
"""What an entity of a scene is made of; only its lines are used here."""
ENTITY = _object(
    "foxglove.SceneEntity",
    {
        "timestamp": TIME,
        "frame_id": _TEXT,
        "id": _TEXT,
        "lifetime": _object("duration", {"sec": _WHOLE, "nsec": _WHOLE}),
        "frame_locked": {"type": "boolean"},
        "metadata": _list(_object("foxglove.KeyValuePair", {"key": _TEXT, "value": _TEXT})),
        **{shape: _list(LINE if shape == "lines" else {"type": "object"}) for shape in SHAPES},
    },
)
WELL_KNOWN: dict[str, Schema] = {
    "foxglove.PoseInFrame": {"timestamp": TIME, "frame_id": _TEXT, "pose": POSE},
    "foxglove.PosesInFrame": {"timestamp": TIME, "frame_id": _TEXT, "poses": _list(POSE)},
    "foxglove.FrameTransform": {
        "timestamp": TIME,
        "parent_frame_id": _TEXT,
        "child_frame_id": _TEXT,
        "translation": VECTOR,
        "rotation": QUATERNION,
    },
    "foxglove.SceneUpdate": {
        "deletions": _list(_object("foxglove.SceneEntityDeletion", {"timestamp": TIME, "type": _WHOLE, "id": _TEXT})),
        "entities": _list(ENTITY),
    },
    "foxglove.Log": {
        "timestamp": TIME,
        "level": _WHOLE,
        "message": _TEXT,
        "name": _TEXT,
        "file": _TEXT,
        "line": _WHOLE,
    },
}
"""Properties of each, as Foxglove publishes them (github.com/foxglove/foxglove-sdk, schemas/jsonschema)."""


def well_known(name: str) -> bytes:
    """One of Foxglove's own, as text."""
    return json.dumps(_object(name, WELL_KNOWN[name])).encode()


def series_schema(name: str, fields: Sequence[Field]) -> bytes:
    """Of a series: a time, and one number a field with its unit; null where it was not measured."""
    numbers = {
        field.name: {"type": ["number", "null"], "unit": field.unit, "description": f"{field.meaning} [{field.unit}]"}
        for field in fields
    }
    return json.dumps(_object(name, {"timestamp": TIME, **numbers})).encode()
