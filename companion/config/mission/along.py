"""What only following the path shows: speed and yaw where the vehicle will be."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

from companion.config.mission.profile_keys import SPEED_MIN
from companion.config.syntax.document import Document
from companion.config.syntax.faults import Fault
from companion.frames import Vec3, wrap
from companion.mission import Mission
from companion.paths.tracing import PathError
from companion.profiles import AutoSpeed, LookAt, SpeedExpression, TangentYaw, YawExpression

LOOK_AT_MIN = 0.5
"""m; nearer to a point there is no heading towards it."""
VERTICAL = 1e-3
"""length of a tangent's level part below which it has no heading."""
CHECK_SAMPLES, CHECK_EVERY = 400, 5.0
"""At least so many places along a path, and one in so many m."""
SPEED_JUMP, YAW_JUMP = 0.1, math.radians(2.0)
"""m/s and rad: a change of an expression as large as this within JUMP_WITHIN is a jump. Engineering choice."""
JUMP_WITHIN = 1e-6
"""m."""


def faults_along(document: Document, mission: Mission) -> list[Fault]:
    """What is wrong with the path, and with speed and yaw on it."""
    try:
        table = mission.table
    except PathError as error:
        return [document.fault(("path",), str(error))]
    faults: dict[str, Fault] = {}
    signs = set()

    def said(key: str, message: str) -> None:
        faults.setdefault(key, document.fault((key,), message))

    count = max(CHECK_SAMPLES, min(20_000, math.ceil(table.length / CHECK_EVERY)))
    last = count if table.closed else count - 1
    for i in range(count):
        s = table.length * i / last
        p_n, tangent, _ = table.at(s)
        where = f"at {_mission_place(mission, p_n)}"
        if not isinstance(mission.speed, AutoSpeed):
            try:
                speed = mission.alpha(s)
                signs.add(speed > 0.0)
                if not abs(speed) >= SPEED_MIN:
                    least = f"expected at least {SPEED_MIN:g} m/s everywhere, or it never leaves"
                    said("speed", f"{speed:.3g} m/s {where}; {least}")
            except (ValueError, ArithmeticError) as error:
                said("speed", f"is not defined {where}: {error}")
        try:
            if isinstance(mission.yaw, TangentYaw) and math.hypot(*tangent[:2]) < VERTICAL:
                said("yaw", f"tangent has no heading {where}: it is vertical")
            target = mission.yaw.target_n if isinstance(mission.yaw, LookAt) else (math.inf, math.inf, 0.0)
            if math.hypot(target[0] - p_n[0], target[1] - p_n[1]) < LOOK_AT_MIN:
                message = f"the path passes within {LOOK_AT_MIN:g} m of the point to face, {where}; no heading there"
                said("yaw", message)
            if not math.isfinite(mission.beta(s)):
                said("yaw", f"is not finite {where}")
        except (ValueError, ArithmeticError) as error:
            said("yaw", f"is not defined {where}: {error}")
    for key, jumped in _jumps(mission, [table.length * i / last for i in range(last + 1)]):
        where = _mission_place(mission, table.at(jumped)[0])
        said(key, f"jumps {jumped:.2f} m along the path, at {where}; expected one that changes smoothly")
    if len(signs) > 1:
        said("speed", "changes sign along the path; expected one direction: it would stop at zero and never leave")
    return list(faults.values())


def _jumps(mission: Mission, places: list[float]) -> list[tuple[str, float]]:
    """The keys of expressions that jump, each with the first arc length (m) at which it does."""
    found = []
    expressions: list[tuple[str, Callable[[float], float], Callable[[float], float], float]] = []
    if isinstance(mission.speed, SpeedExpression):
        expressions.append(("speed", mission.alpha, lambda change: change, SPEED_JUMP))
    if isinstance(mission.yaw, YawExpression):
        expressions.append(("yaw", mission.beta, wrap, YAW_JUMP))
    for key, value, short, size in expressions:
        try:
            jumped = _first_jump(value, places, short, size)
        except (ValueError, ArithmeticError):
            continue  # said where it is not defined
        if jumped is not None:
            found.append((key, jumped))
    return found


def _first_jump(
    value: Callable[[float], float], places: list[float], short: Callable[[float], float], size: float
) -> float | None:
    """The arc length (m) of the first jump between ``places``. ``short``: a change of the value, the short way round;
    ``size``: how large it is where it is a jump. An interval is halved towards its larger change until that is gone."""
    before = value(places[0])
    for begin, end in itertools.pairwise(places):
        low, high, at_low, at_high = begin, end, before, value(end)
        before = at_high
        while abs(short(at_high - at_low)) >= size:
            if high - low < JUMP_WITHIN:
                return high
            middle = 0.5 * (low + high)
            at_middle = value(middle)
            if abs(short(at_middle - at_low)) > abs(short(at_high - at_middle)):
                high, at_high = middle, at_middle
            else:
                low, at_low = middle, at_middle
    return None


def _mission_place(mission: Mission, p_n: Vec3) -> str:
    x, y, z = mission.placement.to_mission(p_n)
    return f"x {x:z.2f}, y {y:z.2f}, z {z:z.2f}"
