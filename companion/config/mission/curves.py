"""The path of a mission file -> the path that is flown."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.calculus.expression import parse as parse_expression
from companion.config.mission import path_keys as keys
from companion.config.syntax.document import Document
from companion.config.syntax.faults import Fault
from companion.frames import Vec3
from companion.mission import Path
from companion.paths.curve import Curve, Shape
from companion.paths.formula import written
from companion.paths.implicit import VARIABLES, ImplicitPath
from companion.paths.lissajous import lissajous
from companion.paths.placement import Placement
from companion.paths.polyline import line, polyline
from companion.paths.round import circle, ellipse, helix
from companion.paths.spline import spline

Kind = (
    keys.CircleModel
    | keys.EllipseModel
    | keys.LissajousModel
    | keys.LineModel
    | keys.PolylineModel
    | keys.SplineModel
    | keys.ExpressionModel
    | keys.HelixModel
)


def implicit_from(model: keys.ImplicitModel, near: list[float] | None, placement: Placement) -> ImplicitPath:
    """The implicit path of a file. ``near``: used where the file's path names no point."""
    names = (*VARIABLES, *model.constants)
    point = model.near or near
    return ImplicitPath(
        h1=parse_expression(model.h1, names),
        h2=parse_expression(model.h2, names),
        near=None if point is None else triple(point),
        constants=model.constants,
        placement=placement,
    )


def curve_from(document: Document, model: Kind, placement: Placement, faults: list[Fault]) -> Path | None:
    """The curve of a file; None where it is none, and why in ``faults``."""
    up: Vec3 = (0.0, 0.0, 1.0) if placement.enu else (0.0, 0.0, -1.0)
    try:
        return _curve(model, up).placed(placement)
    except ValueError as error:
        key = "points" if isinstance(model, keys.PolylineModel | keys.SplineModel) else "kind"
        faults.append(document.fault(("path", key), str(error)))
    except ArithmeticError as error:
        faults.append(document.fault(("path", "kind"), f"is nowhere defined: {error}"))
    return None


def _curve(model: Kind, up: Vec3) -> Curve:
    match model:
        case keys.CircleModel():
            return circle(triple(model.center), model.radius, triple(model.normal or up), up)
        case keys.EllipseModel():
            a, b = model.axes
            return ellipse(triple(model.center), a, b, triple(model.normal or up), up)
        case keys.LissajousModel():
            i, j, k = model.frequency
            x, y, z = map(math.radians, model.phase_deg)
            return lissajous(triple(model.center), triple(model.amplitude), (i, j, k), (x, y, z))
        case keys.LineModel():
            return line(triple(model.from_), triple(model.to))
        case keys.PolylineModel():
            return polyline([triple(p) for p in model.points], model.closed, model.corner_tolerance)
        case keys.SplineModel():
            return spline([triple(p) for p in model.points], model.closed)
        case keys.HelixModel():
            return helix(triple(model.center), model.radius, model.pitch, model.turns, up)
        case keys.ExpressionModel():
            names = ("u", *model.constants)
            x_of, y_of, z_of = (parse_expression(text, names) for text in (model.x, model.y, model.z))
            u0, u1 = model.u
            return Curve(Shape(written(x_of, y_of, z_of, model.constants), u0, u1, model.closed))


def triple(values: Sequence[float]) -> Vec3:
    """Three numbers of a file as a point or a direction."""
    x, y, z = values
    return (float(x), float(y), float(z))
