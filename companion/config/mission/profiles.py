"""Speed and yaw of a mission file -> alpha and beta."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

from companion.calculus.expression import parse as parse_expression
from companion.config.mission import profile_keys as keys
from companion.config.mission.curves import triple
from companion.config.mission.path_keys import ExpressionModel, ImplicitModel, PathModel
from companion.config.mission.profile_keys import SpeedModel, YawModel
from companion.config.plan.to_mission import PlannedPath
from companion.config.syntax.document import Document
from companion.config.syntax.faults import Fault
from companion.config.syntax.units import not_radians
from companion.mission import Path
from companion.paths.implicit import VARIABLES
from companion.paths.tracing import PathError
from companion.profiles import (
    AutoSpeed,
    ConstantSpeed,
    ConstantYaw,
    LookAt,
    Speed,
    SpeedExpression,
    TangentYaw,
    Yaw,
    YawExpression,
    speed_table,
    yaw_table,
)

P = TypeVar("P")


def known_names(path: PathModel) -> tuple[str, ...]:
    """What expressions for speed and yaw may name along a path."""
    if isinstance(path, ImplicitModel):
        return (*VARIABLES, *path.constants)
    return ("s", *path.constants) if isinstance(path, ExpressionModel) else ("s",)


def constant_in_degrees(expression: str) -> None:
    """ValueError: a heading that is the same everywhere, and looks like an angle in radians."""
    try:
        value = float(parse_expression(expression, ())({}))
    except (ValueError, ArithmeticError):
        return  # it names what changes along the path
    not_radians(value)


class Profiles:
    """Reads the speed and the yaw of one file for its path; what is wrong goes into ``faults``."""

    def __init__(
        self, document: Document, model: PathModel, path: Path, faults: list[Fault], plan: PlannedPath | None = None
    ) -> None:
        self._document = document
        self._plan = plan
        self._path = path
        self._faults = faults
        self._names = known_names(model)
        self._constants = model.constants if isinstance(model, ImplicitModel | ExpressionModel) else {}

    def speed(self, given: SpeedModel) -> Speed | None:
        """alpha; None where it is none."""
        match given:
            case keys.AutoSpeedModel(auto=auto):
                return AutoSpeed(-1.0 if auto.reverse else 1.0, auto.speed_max, auto.margin)
            case "auto":
                return AutoSpeed()
            case "plan" if self._plan is not None:
                return self._plan.speed
            case keys.SpeedTableModel():
                return self._table("speed", given.table, speed_table, self._moves)
            case str():
                return SpeedExpression(parse_expression(given, self._names), self._constants)
        return ConstantSpeed(float(given))

    def yaw(self, given: YawModel) -> Yaw | None:
        """beta; None where it is none."""
        match given:
            case keys.LookAtModel():
                return LookAt(triple(given.look_at))
            case keys.TangentModel():
                return TangentYaw(math.radians(given.tangent))
            case "tangent":
                return TangentYaw()
            case "plan" if self._plan is not None:
                return self._plan.yaw
            case keys.YawTableModel():
                rows = [[s, math.radians(heading)] for s, heading in given.table]
                return self._table("yaw", rows, yaw_table, lambda rows: None)
            case str():
                return YawExpression(parse_expression(given, self._names), self._constants)
        return ConstantYaw(math.radians(given))

    def _table(
        self,
        key: str,
        rows: list[list[float]],
        make: Callable[[list[tuple[float, float]], float | None], P],
        check: Callable[[list[list[float]]], None],
    ) -> P | None:
        before = len(self._faults)
        try:
            table = self._path.table
        except PathError:
            return None  # said elsewhere
        length = table.length
        at = -1.0
        for i, (s, _) in enumerate(rows):
            if not 0.0 <= s <= length * (1.0 + 1e-6):
                message = f"{s:g} m lies beyond the path; expected 0 to {length:.2f} m"
                self._fault((key, "table", i), message)
                break
            if s <= at:
                self._fault((key, "table", i), f"{s:g} m after {at:g} m; expected rising distances")
                break
            at = s
        check(rows)
        if len(self._faults) > before:
            return None
        return make([(s, value) for s, value in rows], length if table.closed else None)

    def _moves(self, rows: list[list[float]]) -> None:
        for i, (_, speed) in enumerate(rows):
            if abs(speed) < keys.SPEED_MIN:
                message = f"{speed:g} m/s; expected at least {keys.SPEED_MIN:g} m/s everywhere, or it never leaves"
                self._fault(("speed", "table", i), message)
            elif speed * rows[0][1] < 0.0:
                message = f"{speed:g} m/s after {rows[0][1]:g}; expected one direction: it would stop and never leave"
                self._fault(("speed", "table", i), message)

    def _fault(self, key: tuple[str | int, ...], message: str) -> None:
        self._faults.append(self._document.fault(key, message))
