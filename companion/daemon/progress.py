"""What a person watching a flight sees: one line that says where it stands; and from another terminal, a few more."""

from __future__ import annotations

import math

from companion.daemon.conductor import Conductor, Tick
from companion.daemon.orders import Orders
from companion.flight.phases import Phase
from companion.pilot import latest_steered, yaw_error
from companion.record.folder import Recorder

OFF_THE_PATH = (Phase.TAKE_OFF, Phase.LAND, Phase.RETURN, Phase.DISARM, Phase.RELEASE)
"""Phases in which the autopilot flies by itself: its height is of interest, and no error of the path."""
OLD_AFTER = 1.0
"""s after which a state is no news for a line that comes once a second (engineering choice)."""


def line(tick: Tick, rate: float, garbage: int = 0, ground: float | None = None) -> str:
    """Time of following, path error, speed, yaw error, tilt, loop rate; bytes that were no message, if there were.

    Where the autopilot takes off or lands: its height above ``ground`` (m, down) in the place of the path's figures.
    Where no state has come for OLD_AFTER: for how long, and no figure of the last one.
    """
    memory, steered, state = tick.memory, latest_steered(tick.memory, tick.outcome), tick.memory.state
    parts = [f"{memory.phase.value:<10}"]
    age = 0.0 if memory.state_at is None else tick.now - memory.state_at
    if age > OLD_AFTER:
        steered = state = None
        parts.append(f"no state for {age:.0f} s")
    elif memory.phase in OFF_THE_PATH:
        if state is not None and ground is not None:
            parts.append(f"height {ground - state.p_n[2]:z6.1f} m")
    else:
        if memory.path.follow_from is not None and state is not None:
            parts.append(f"{state.t_boot - memory.path.follow_from:6.1f} s")
        if memory.path.progress is not None:
            parts.append(f"path error {100.0 * memory.path.progress.path_error:6.1f} cm")
    if steered is not None:
        parts.append(f"speed {steered.command.speed:z6.2f} of {steered.command.alpha:z.2f} m/s")
        parts.append(f"yaw error {math.degrees(yaw_error(steered)):z6.1f} deg")
    if state is not None:
        parts.append(f"tilt {math.degrees(state.tilt):4.1f} deg")
    parts.append(f"{rate:.0f} Hz")
    if garbage:
        parts.append(f"{garbage} bytes of garbage")
    return "  ".join(parts)


def about(orders: Orders, link: str, recorder: Recorder | None) -> dict[str, str | None]:
    """What does not change in a flight, for another terminal."""
    return {
        "mission": orders.mission.name,
        "vehicle": orders.vehicle.name,
        "output": "auto" if orders.auto else orders.level.value,
        "link": link,
        "record": None if recorder is None else str(recorder.directory.resolve()),
    }


def status_document(conductor: Conductor) -> dict[str, str | None]:
    """Where a flight stands, for another terminal."""
    status, plan = conductor.telemetry.status.last, conductor.plan
    phase = "waits for a vehicle" if conductor.link.identity is None else "learns about the vehicle"
    said: dict[str, str | None] = {"phase": phase, "mode": None, "battery": None}
    if conductor.memory is not None:
        said["phase"] = conductor.memory.phase.value
    if plan is not None:
        said["output"] = plan.level.value
    others = conductor.link.peers.words()
    if others:
        said["others"] = "; ".join(others)
    if status.mode is not None:
        said["mode"] = f"{status.mode.words}, {'armed' if status.armed else 'disarmed'}"
    if status.battery is not None:
        said["battery"] = f"{100.0 * status.battery:.0f} %"
    return said


class Watch:
    """Turns a conductor into lines at intervals of the given clock."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._shown_at: float | None = None
        self._states = 0

    def look(self, conductor: Conductor, now: float) -> str | None:
        """The line that is due, or None."""
        tick = conductor.last
        if tick is None:
            return None
        if self._shown_at is None:
            self._shown_at, self._states = now, conductor.states
            return None
        passed = now - self._shown_at
        if passed < self._period:
            return None
        rate = (conductor.states - self._states) / passed
        self._shown_at, self._states = now, conductor.states
        ground = None if conductor.plan is None else conductor.plan.conduct.limits.ground
        return line(tick, rate, conductor.decoder.counters.garbage_bytes, ground)
