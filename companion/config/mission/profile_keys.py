"""Speed and yaw along a path, as a mission file writes them."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Discriminator, Field, Tag

from companion.config.mission.path_keys import Point
from companion.config.syntax.schema import Strict
from companion.config.syntax.units import not_radians

SPEED_MIN = 0.05
"""m/s; a speed given over displacement that comes to zero never leaves it again."""
MetresPerSecond = Annotated[float, Field(ge=-100.0, le=100.0)]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0), AfterValidator(not_radians)]
Row = Annotated[list[float], Field(min_length=2, max_length=2)]
Rows = Annotated[list[Row], Field(min_length=2, max_length=100_000)]


class SpeedTableModel(Strict):
    """A speed through samples along the path, smooth between them."""

    table: Rows
    """samples [distance along the path in m, speed in m/s], in order"""


class AutoModel(Strict):
    """How `auto` may use the vehicle."""

    margin: Annotated[float, Field(ge=0.3, le=1.0)] = 0.9
    """the share of every limit that may be used, 0.3 to 1"""
    speed_max: Annotated[float, Field(ge=SPEED_MIN, le=100.0)] | None = None
    """never faster than this, in m/s; the vehicle's own limit where absent"""
    reverse: bool = False
    """whether the path is flown the other way"""


class AutoSpeedModel(Strict):
    """The fastest speed that the vehicle can fly, with a say in it."""

    auto: AutoModel
    """how it is found (margin, speed_max, reverse)"""


class LookAtModel(Strict):
    """Always face one point."""

    look_at: Point
    """the point [x, y, z] to face, in m"""


class TangentModel(Strict):
    """Face along the path."""

    tangent: Degrees
    """degrees to add to the heading of travel"""


class YawTableModel(Strict):
    """A heading through samples along the path, smooth between them, each time the short way round."""

    table: Rows
    """samples [distance along the path in m, heading in degrees clockwise from north], in order"""


def _speed_form(value: Any) -> str:
    if isinstance(value, dict):
        return "auto with options" if "auto" in value else "a table"
    return "words" if isinstance(value, str) else "a number"


def _yaw_form(value: Any) -> str:
    if isinstance(value, dict):
        return "a point to face" if "look_at" in value else "a table" if "table" in value else "along the path"
    return "words" if isinstance(value, str) else "a number"


SpeedModel = Annotated[
    Annotated[MetresPerSecond, Tag("a number")]
    | Annotated[str, Tag("words")]
    | Annotated[SpeedTableModel, Tag("a table")]
    | Annotated[AutoSpeedModel, Tag("auto with options")],
    Discriminator(_speed_form),
]
YawModel = Annotated[
    Annotated[Degrees, Tag("a number")]
    | Annotated[str, Tag("words")]
    | Annotated[LookAtModel, Tag("a point to face")]
    | Annotated[TangentModel, Tag("along the path")]
    | Annotated[YawTableModel, Tag("a table")],
    Discriminator(_yaw_form),
]
