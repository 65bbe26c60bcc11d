"""``law``: the paper's mathematics, one state a line in, one answer a line out. No limit, clamp, wrap or drag."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, TextIO

from companion.allocation import Allocation
from companion.calculus.vectors import Vector
from companion.cli.terminal import say
from companion.frames import Vec3
from companion.law.bare import Answer, bare_law, state_names
from companion.law.errors import LawError
from companion.law.gains import Level, default_gains
from companion.law.motion import Model
from companion.mission import Mission
from companion.paths.arc import ArcTable
from companion.paths.implicit import ImplicitPath
from companion.paths.tracing import PathError
from companion.vehicle import Vehicle


class Unanswered(NamedTuple):
    """How many lines had no answer: ``unreadable`` ones that are no state, and states where the law is not defined."""

    unreadable: int
    undefined: int

    @property
    def exit_code(self) -> int:
        """2 where a line was no state, 1 where the law was not defined at one, else 0."""
        return 2 if self.unreadable else 1 if self.undefined else 0


def answers(mission: Mission, vehicle: Vehicle, level: Level, lines: Iterable[str], out: TextIO) -> Unanswered:
    """Answer every line of JSON that is not blank. A line without an answer says so in its place, and on stderr with
    its number; the run goes on."""
    model = Model(vehicle.mass, Vector(*vehicle.inertia), vehicle.gravity)
    gains = mission.gains if mission.gains is not None else default_gains(level)
    law = bare_law(mission.specification(1.0), level, model, gains)
    allocation = Allocation(vehicle)
    curve = _Curve(mission)
    unreadable = undefined = 0
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        answer = _answer(line, level, law, allocation, curve)
        out.write(json.dumps(answer) + "\n")
        out.flush()
        if "error" in answer:
            read = _state(line, level)
            unreadable, undefined = unreadable + isinstance(read, str), undefined + (not isinstance(read, str))
            say(f"line {number}: {answer['error']}")
    return Unanswered(unreadable, undefined)


class _Curve:
    """The traced curve, where h1 = h2 = 0 has one: the law itself does not need it."""

    def __init__(self, mission: Mission) -> None:
        self._path = mission.path
        self._table: ArcTable | None = None
        self._traced = False

    def eta(self, p_n: Vec3) -> float | None:
        """The arc length next to a point. A mission that names no point near the path means the one near the first."""
        if not self._traced:
            self._traced = True
            path = self._path
            if isinstance(path, ImplicitPath) and path.near is None:
                path = dataclasses.replace(path, near=path.placement.to_mission(p_n))
            try:
                self._table = path.table
            except PathError as error:
                say(f"eta is null: the path {error}")
        return None if self._table is None else self._table.locate(p_n)[0]


def _chi(line: str) -> list[int | float] | None:
    """The numbers of a line; None where it is no state."""
    try:
        document = json.loads(line)
    except (ValueError, RecursionError):
        return None
    chi = document.get("chi") if isinstance(document, dict) else None
    if not isinstance(chi, list):
        return None
    return chi if all(isinstance(value, int | float) and not isinstance(value, bool) for value in chi) else None


def _state(line: str, level: Level) -> list[float] | str:
    """The state of a line; or what is wrong with it."""
    names, chi = state_names(level), _chi(line)
    if chi is None:
        return f'not a state: expected {{"chi": [{", ".join(names)}]}}'
    try:
        state = [float(value) for value in chi]
    except OverflowError:
        return "a number that is not finite"
    if len(state) != len(names):
        return f"{len(state)} numbers; expected {len(names)}: {', '.join(names)}"
    return state if all(map(math.isfinite, state)) else "a number that is not finite"


def _answer(
    line: str, level: Level, law: Callable[[list[float]], Answer], allocation: Allocation, curve: _Curve
) -> dict[str, Any]:
    state = _state(line, level)
    if isinstance(state, str):
        return {"error": state}
    try:
        answer = law(state)
    except LawError as error:
        return {"error": str(error)}
    document: dict[str, Any] = {"xi": answer.xi, "b": answer.b, "D": answer.D}
    if level is Level.MOTORS:
        zeta = state[-2]
        u2, u3, u4 = answer.inputs[1:]
        document["ubar"] = answer.inputs
        document["tau"] = allocation.motor_torques((zeta, u2, u3, u4))
    else:
        document["u"] = answer.inputs
    document["eta"] = curve.eta((state[0], state[1], state[2]))
    return document
