"""The fence of a mission file: where the vehicle may be."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, WithJsonSchema, model_validator

from companion.config.mission.path_keys import Coordinate, Metres
from companion.config.syntax.schema import Strict
from companion.fence import Area, Circle, Fence, Polygon

_PAIR = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
_PLACE = {
    "type": "object",
    "properties": {
        "lat": {"type": "number", "minimum": -89, "maximum": 89, "description": "latitude in degrees"},
        "lon": {"type": "number", "minimum": -180, "maximum": 180, "description": "longitude in degrees"},
    },
    "required": ["lat", "lon"],
    "additionalProperties": False,
}
Corner = Annotated[list[Coordinate], Field(min_length=2, max_length=2), WithJsonSchema({"anyOf": [_PAIR, _PLACE]})]
Corners = Annotated[list[Corner], Field(min_length=3, max_length=1000)]


class FenceCircleModel(Strict):
    """A circle, seen from above."""

    center: Corner
    """its centre [x, y], in m"""
    radius: Metres
    """its radius, in m"""


def _form(value: Any) -> str:
    return "a circle" if isinstance(value, dict) else "corners"


AreaModel = Annotated[
    Annotated[Corners, Tag("corners")] | Annotated[FenceCircleModel, Tag("a circle")], Discriminator(_form)
]


class FenceModel(Strict):
    """One area of a fence: stay inside of it, or outside."""

    inside: AreaModel | None = None
    """where to stay inside of: corners [[x, y], ..] in m, or {center: [x, y], radius: m}"""
    outside: AreaModel | None = None
    """where to stay out of: corners [[x, y], ..] in m, or {center: [x, y], radius: m}"""

    @model_validator(mode="after")
    def _is_one(self) -> FenceModel:
        if (self.inside is None) == (self.outside is None):
            raise ValueError("expected one of inside and outside")
        return self


def fence_from(models: list[FenceModel]) -> Fence | None:
    """The fence, in the mission's coordinates; None where there is none."""
    return Fence(tuple(map(_area, models))) if models else None


def _area(model: FenceModel) -> Area:
    inside = model.inside is not None
    given = model.inside if model.inside is not None else model.outside
    if isinstance(given, FenceCircleModel):
        return Circle((given.center[0], given.center[1]), given.radius, inside)
    assert given is not None
    return Polygon(tuple((x, y) for x, y in given), inside)
