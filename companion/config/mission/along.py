"""What only following the path shows: speed and yaw where the vehicle will be."""

from __future__ import annotations

import math

from companion.config.mission.profile_keys import SPEED_MIN
from companion.config.syntax.document import Document
from companion.config.syntax.faults import Fault
from companion.frames import Vec3
from companion.mission import Mission
from companion.paths.tracing import PathError
from companion.profiles import AutoSpeed, LookAt, TangentYaw

LOOK_AT_MIN = 0.5
"""m; nearer to a point there is no heading towards it."""
VERTICAL = 1e-3
CHECK_SAMPLES, CHECK_EVERY = 400, 5.0
"""At least so many places along a path, and one in so many m."""


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
    if len(signs) > 1:
        said("speed", "changes sign along the path; expected one direction: it would stop at zero and never leave")
    return list(faults.values())


def _mission_place(mission: Mission, p_n: Vec3) -> str:
    x, y, z = mission.placement.to_mission(p_n)
    return f"x {x:.2f}, y {y:.2f}, z {z:.2f}"
