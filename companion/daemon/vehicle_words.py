"""Where the vehicle is and what to do next, for somebody who ended a flight by hand."""

from __future__ import annotations

import math

from companion.daemon.conductor import Conductor
from companion.vehicle import KnownStatus, Landed, Mode, VehicleState

LATE = 1.0
"""s without a state after which it is said when the last one came (engineering choice)."""
FLIES_ITSELF = frozenset({Mode.LAND, Mode.RETURN, Mode.TAKEOFF, Mode.MISSION})
"""The modes in which PX4 goes somewhere by itself."""


def describe_vehicle(conductor: Conductor, now: float) -> str | None:
    """Both in one sentence without its full stop; None where no vehicle was heard. ``now``: s, as at the doors."""
    if conductor.link.identity is None:
        return None
    status = conductor.telemetry.status.last
    memory = conductor.memory
    state = None if memory is None else memory.state
    parts = [_mode(status), _place(conductor, status, state)]
    age = None if memory is None or memory.state_at is None else now - memory.state_at
    if age is not None and age > LATE:
        parts.append(f"last heard {age:.0f} s ago")
    return f"the vehicle is {', '.join(part for part in parts if part)}; {_next(status)}"


def _mode(status: KnownStatus) -> str:
    mode = "in an unknown mode" if status.mode is None else f"in {status.mode.words}"
    return mode if status.armed is None else f"{mode}, {'armed' if status.armed else 'disarmed'}"


def _place(conductor: Conductor, status: KnownStatus, state: VehicleState | None) -> str:
    if status.landed is Landed.ON_GROUND:
        return "on the ground"
    if state is None:
        return ""
    home = conductor.telemetry.home
    if home is None:
        return f"{-state.p_n[2]:.1f} m above its origin"
    level = math.hypot(state.p_n[0] - home.p_n[0], state.p_n[1] - home.p_n[1])
    return f"{home.p_n[2] - state.p_n[2]:.1f} m above home and {level:.0f} m from it"


def _next(status: KnownStatus) -> str:
    if status.armed is False:
        return "it can be walked up to"
    if status.landed is Landed.ON_GROUND:
        return "disarm it before anybody walks up to it"
    if status.mode is Mode.HOLD:
        return "it stays there until somebody takes it: by remote control or from a ground station"
    if status.mode is Mode.OFFBOARD:
        return "select another mode now, by remote control or from a ground station"
    if status.mode in FLIES_ITSELF:
        return "it flies by itself: watch it, and take it by remote control if need be"
    return "look at it, and take it by remote control"
