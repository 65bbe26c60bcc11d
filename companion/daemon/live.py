"""A flight as it happens, for the live page: two more small files beside the status file (see ``status_file``).

``PID.live`` is written anew 20 times a second by a thread of its own, ``PID.path`` once a plan. The control thread is
only read: what it leaves in ``conductor.last`` is never changed, only replaced.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from companion.daemon.conductor import Conductor, Tick
from companion.daemon.scribe import Helper
from companion.daemon.status_file import LIVE, PATH, own_directory
from companion.frames import euler_from_rotation
from companion.pilot import latest_steered, yaw_error
from companion.plan import Plan
from companion.record.owned_files import READABLE, write_owned

PERIOD = 0.05
"""s between two words: 20 Hz, what a screen shows (engineering choice)."""
PATH_POINTS = 300
"""Points of the path that a page draws: 9 kB (engineering choice)."""


def live_document(conductor: Conductor, now: float) -> dict[str, Any] | None:
    """Where the vehicle is and how well the path is held: m, m/s, degrees; None before the first tick."""
    tick, plan = conductor.last, conductor.plan
    if tick is None or plan is None:
        return None
    memory, state = tick.memory, tick.memory.state
    said: dict[str, Any] = {"phase": memory.phase.value, "fault": memory.first_fault}
    if state is not None:
        said |= {
            "p_n": _round(state.p_n),
            "v_n": _round(state.v_n),
            "yaw_deg": _round(math.degrees(euler_from_rotation(state.r_nb)[0])),
            "tilt_deg": _round(math.degrees(state.tilt)),
        }
        if memory.path.follow_from is not None:
            said["follow_s"] = _round(state.t_boot - memory.path.follow_from)
    if memory.path.progress is not None:
        said |= {"path_error_m": _round(memory.path.progress.path_error), "s_m": _round(memory.path.progress.s)}
    steered = latest_steered(memory, tick.outcome)
    if steered is not None:
        speed = steered.command.speed * (-1.0 if memory.path.leg < 0.0 else 1.0)
        said |= {
            "speed_mps": _round(speed),
            "speed_error_mps": _round(speed - steered.command.alpha),
            "yaw_error_deg": _round(math.degrees(yaw_error(steered))),
            "thrust_n": _round(steered.thrust),
        }
    said["guards"] = guards(tick, plan)
    said["link"] = {
        "age_s": None if memory.state_at is None else _round(now - memory.state_at),
        "round_trip_s": _round(tick.observation.round_trip),
        "rate_hz": _round(tick.observation.rate),
    }
    status = conductor.telemetry.status.last
    said |= {"battery": _round(status.battery), "armed": status.armed}
    said["mode"] = None if status.mode is None else status.mode.words
    return said


def guards(tick: Tick, plan: Plan) -> list[dict[str, Any]]:
    """How much of each limit is used: 1 is where the guard acts. Only what is known and has a limit."""
    memory, limits = tick.memory, plan.conduct.limits
    state = memory.state
    found: list[tuple[str, float, float, str]] = []
    if memory.path.progress is not None and memory.path.reached and limits.tube is not None:
        found.append(("tube", memory.path.progress.path_error, limits.tube, "m"))
    if state is not None and limits.tilt is not None:
        found.append(("tilt", math.degrees(state.tilt), math.degrees(limits.tilt), "deg"))
    if state is not None and limits.ground is not None and limits.ceiling is not None:
        found.append(("ceiling", limits.ground - state.p_n[2], limits.ceiling, "m"))
    if state is not None and limits.home is not None:
        north, east, down = (a - b for a, b in zip(state.p_n, limits.home, strict=True))
        if limits.radius is not None:
            found.append(("fence radius", math.hypot(north, east), limits.radius, "m"))
        if limits.height is not None:
            found.append(("fence height", -down, limits.height, "m"))
    usage = [
        {
            "name": name,
            "value": _round(value),
            "limit": _round(limit),
            "unit": unit,
            "used": _round(value / limit),
        }
        for name, value, limit, unit in found
        if limit > 0.0
    ]
    if state is not None and limits.ground is not None and limits.floor is not None:
        height = limits.ground - state.p_n[2]
        used = 1.0 if height <= 0.0 else limits.floor / height
        usage.append(
            {
                "name": "floor",
                "value": _round(height),
                "limit": _round(limits.floor),
                "unit": "m",
                "used": _round(used),
            }
        )
    return usage


def path_document(plan: Plan) -> dict[str, Any]:
    """The path in the vehicle's local frame: points north, east, down in m."""
    _, points = plan.table.samples(PATH_POINTS)
    return {"points": [_round(tuple(point)) for point in points.tolist()], "closed": plan.table.closed}


class Publisher(Helper):
    """Writes both files. A directory that cannot be written to is no reason not to fly."""

    period = PERIOD

    def __init__(
        self,
        conductor: Conductor,
        lines: deque[str],
        clock: Callable[[], float],
        environment: Mapping[str, str] = os.environ,
    ) -> None:
        super().__init__("live view", lines, clock)
        self._conductor = conductor
        self._stem = own_directory(environment) / str(os.getpid())
        self._drawn: Plan | None = None

    def work(self, now: float) -> None:
        """See Helper."""
        plan = self._conductor.plan
        if plan is not None and plan is not self._drawn:
            self._drawn = plan
            write_owned(self._stem.with_suffix(PATH), json.dumps(path_document(plan)), READABLE)
        said = live_document(self._conductor, now)
        if said is not None:
            write_owned(self._stem.with_suffix(LIVE), json.dumps(said), READABLE)

    def remove(self) -> None:
        """The flight is over."""
        for suffix in (LIVE, PATH):
            with contextlib.suppress(OSError):
                self._stem.with_suffix(suffix).unlink()


def _round(value: Any) -> Any:
    """Four decimals, and None for what JSON has no number for."""
    if isinstance(value, tuple):
        return [_round(part) for part in value]
    return None if value is None or not math.isfinite(value) else round(value, 4)
