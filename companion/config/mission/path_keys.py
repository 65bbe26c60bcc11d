"""The kinds of path a mission may have, as its file writes them."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)

from companion.calculus.expression import CONSTANTS, FUNCTIONS
from companion.calculus.expression import parse as parse_expression
from companion.config.syntax.schema import Strict
from companion.config.syntax.units import not_radians
from companion.paths.implicit import VARIABLES

Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
_TRIPLE = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
_PLACE = {
    "type": "object",
    "properties": {
        "lat": {"type": "number", "minimum": -89, "maximum": 89, "description": "latitude in degrees"},
        "lon": {"type": "number", "minimum": -180, "maximum": 180, "description": "longitude in degrees"},
        "above_home": {"type": "number", "description": "height above the vehicle's home, in m"},
        "amsl": {"type": "number", "description": "height above mean sea level, in m"},
    },
    "required": ["lat", "lon"],
    "additionalProperties": False,
}
"""What ``earth`` turns into a point before a model sees it."""
Point = Annotated[list[Coordinate], Field(min_length=3, max_length=3), WithJsonSchema({"anyOf": [_TRIPLE, _PLACE]})]


def _origin_form(value: Any) -> str:
    return "a place" if isinstance(value, list) else "a word"


Triple = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
OriginModel = Annotated[
    Annotated[
        Annotated[Literal["local", "takeoff", "home"], Tag("a word")]
        | Annotated[list[float], Field(min_length=3, max_length=3), Tag("a place")],
        Discriminator(_origin_form),
    ]
    | None,
    WithJsonSchema({"anyOf": [{"enum": ["local", "takeoff", "home"]}, _TRIPLE, _PLACE]}),
]
Metres = Annotated[float, Field(gt=0.0, le=1e5)]
Points = Annotated[list[Point], Field(min_length=2, max_length=100_000)]
Phase = Annotated[float, Field(ge=-720.0, le=720.0), AfterValidator(not_radians)]
Frequency = Annotated[int, Field(ge=0, le=50)]
Constants = dict[str, float]


def _as_text(value: Any) -> Any:
    return repr(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


Formula = Annotated[str, BeforeValidator(_as_text), WithJsonSchema({"type": ["string", "number"]})]
"""An expression; a plain number is one too."""


class _WithConstants(Strict):
    """Expressions may name constants."""

    variables: ClassVar[tuple[str, ...]]

    constants: Constants = Field(default_factory=dict)
    """names for numbers in the expressions, e.g. {r: 10}"""

    @field_validator("constants")
    @classmethod
    def _names_of_their_own(cls, constants: Constants) -> Constants:
        for name in constants:
            if not name.isidentifier() or name in (*cls.variables, "s", *CONSTANTS, *FUNCTIONS):
                raise ValueError(f"{name!r} cannot name a constant; expected a word that means nothing else here")
        return constants


class ImplicitModel(_WithConstants):
    """A path given as in the paper: the points where h1 = h2 = 0."""

    variables = VARIABLES

    kind: Literal["implicit"]
    """the kind of path"""
    h1: Formula
    """an expression in x, y, z (m) and the constants that is zero on the path"""
    h2: Formula
    """an expression in x, y, z (m) and the constants that is zero on the path"""
    near: Point | None = None
    """a point [x, y, z] near the part of h1 = h2 = 0 that is meant, in m"""

    @field_validator("h1", "h2")
    @classmethod
    def _parses(cls, text: str, info: ValidationInfo) -> str:
        if "constants" in info.data:
            parse_expression(text, (*VARIABLES, *info.data["constants"]))
        return text


class _Round(Strict):
    """Runs clockwise seen from above at positive speed, from the mission's x axis on."""

    center: Point
    """the centre [x, y, z], in m"""
    normal: Triple | None = None
    """the direction [x, y, z] that stands on its plane, no unit; vertical where absent"""

    @field_validator("normal")
    @classmethod
    def _points_somewhere(cls, normal: list[float] | None) -> list[float] | None:
        if normal is not None and sum(x * x for x in normal) < 1e-12:
            raise ValueError(f"{normal} has no direction; expected e.g. [0, 0, -1]")
        return normal


class CircleModel(_Round):
    """A circle."""

    kind: Literal["circle"]
    """the kind of path"""
    radius: Metres
    """the radius, in m"""


class EllipseModel(_Round):
    """An ellipse."""

    kind: Literal["ellipse"]
    """the kind of path"""
    axes: Annotated[list[Metres], Field(min_length=2, max_length=2)]
    """the semi-axes [along x, across], in m"""


class LissajousModel(Strict):
    """Each coordinate a sine of its own: center + amplitude sin(frequency u + phase), u from 0 to 2 pi."""

    kind: Literal["lissajous"]
    """the kind of path"""
    center: Point
    """the centre [x, y, z], in m"""
    amplitude: Triple
    """how far it swings along [x, y, z], in m"""
    frequency: Annotated[list[Frequency], Field(min_length=3, max_length=3)]
    """how often it swings along [x, y, z] in a round: whole numbers"""
    phase_deg: Annotated[list[Phase], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0]
    )
    """where in its swing each coordinate begins [x, y, z], in degrees; 90 is its far end"""


class LineModel(Strict):
    """A straight line."""

    kind: Literal["line"]
    """the kind of path"""
    from_: Annotated[Point, Field(alias="from")]
    """the beginning [x, y, z], in m"""
    to: Point
    """the end [x, y, z], in m"""


class PolylineModel(Strict):
    """Straight legs with rounded corners."""

    kind: Literal["polyline"]
    """the kind of path"""
    points: Points
    """the corners, a list of [x, y, z], in m"""
    closed: bool = False
    """whether the last point is joined to the first"""
    corner_tolerance: Annotated[float, Field(ge=0.01, le=1000.0)]
    """how far from a corner the path may pass it, in m"""


class SplineModel(Strict):
    """A smooth curve through points (quintic spline)."""

    kind: Literal["spline"]
    """the kind of path"""
    points: Points
    """the points it passes through, a list of [x, y, z], in m"""
    closed: bool = False
    """whether it runs on from the last point to the first"""


class ExpressionModel(_WithConstants):
    """A curve of your own: x, y, z as expressions in u."""

    variables = ("u",)

    kind: Literal["expression"]
    """the kind of path"""
    x: Formula
    """the x coordinate in m, an expression in u and the constants"""
    y: Formula
    """the y coordinate in m, an expression in u and the constants"""
    z: Formula
    """the z coordinate in m, an expression in u and the constants"""
    u: Annotated[list[Annotated[float, Field(ge=-1e6, le=1e6)]], Field(min_length=2, max_length=2)]
    """where u begins and ends, [u0, u1], no unit of its own"""
    closed: bool = False
    """whether the end is the beginning"""

    @field_validator("x", "y", "z")
    @classmethod
    def _parses(cls, text: str, info: ValidationInfo) -> str:
        if "constants" in info.data:
            parse_expression(text, ("u", *info.data["constants"]))
        return text

    @field_validator("u")
    @classmethod
    def _rises(cls, u: list[float]) -> list[float]:
        if not u[0] < u[1]:
            raise ValueError(f"{u} does not rise; expected [u0, u1] with u0 < u1 (a negative speed runs backwards)")
        return u


class HelixModel(Strict):
    """Turns about a vertical axis that climb; clockwise seen from above at positive speed."""

    kind: Literal["helix"]
    """the kind of path"""
    center: Point
    """the centre [x, y, z] of its first turn, in m"""
    radius: Metres
    """the radius, in m"""
    pitch: Annotated[float, Field(ge=-1000.0, le=1000.0)]
    """how far a turn climbs (negative: sinks), in m"""
    turns: Annotated[float, Field(gt=0.0, le=1000.0)]
    """how many turns"""


class PlanModel(Strict):
    """The route of a QGroundControl .plan or a .waypoints file, its corners rounded."""

    kind: Literal["plan"]
    """the kind of path"""
    file: Annotated[str, Field(min_length=1)]
    """the file, from where the mission file lies"""
    corner_tolerance: Annotated[float, Field(ge=0.01, le=1000.0)] = 1.0
    """how far from a waypoint the path may pass it, in m"""
    smooth: bool = False
    """whether a smooth curve is laid through the waypoints instead of straight legs"""


PathModel = Annotated[
    ImplicitModel
    | CircleModel
    | EllipseModel
    | LissajousModel
    | LineModel
    | PolylineModel
    | SplineModel
    | ExpressionModel
    | HelixModel
    | PlanModel,
    Field(discriminator="kind"),
]
