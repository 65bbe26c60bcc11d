"""How a flight ended, in one sentence: what happened, what was done, what to do next."""

from __future__ import annotations

from typing import NamedTuple

from companion.flight.phases import Event
from companion.vehicle import Mode

ADVICE: dict[Event, str] = {
    Event.STALE: "check the link, then start again",
    Event.STATUS_LOST: "check the link, take the vehicle by remote control, then start again",
    Event.SILENT: "it goes on by itself as it was told: watch it, take it by remote control, and check the link",
    Event.NOT_OURS: "put it in Hold or Position, or on the ground, then start again",
    Event.LAW_FAILED: "companion check says where the mission cannot be flown",
    Event.TAKEN_OVER: "start again when it is to fly the path",
    Event.FAILSAFE: "the ground station shows the failsafe's cause",
    Event.DISARMED_EXTERNALLY: "look at the vehicle before it is armed again",
    Event.REFUSED: "the ground station shows the reason",
    Event.TIMED_OUT: "put that right, then start again",
}
"""By what happened."""

FATE: dict[Event, str] = {
    Event.TAKEN_OVER: "nothing more was sent",
    Event.LET_GO: "nothing more was sent, and the vehicle is in {mode} and will not return to OFFBOARD",
    Event.DISARMED: "the vehicle is disarmed",
}
"""By what ended the flight, where that does not depend on what was asked."""


class Done(NamedTuple):
    """What was done: ``flew`` in OFFBOARD on our setpoints, ``armed`` by us; HOLD ``hold_asked`` times,
    ``hold_accepted`` or not."""

    flew: bool = False
    armed: bool = False
    hold_asked: int = 0
    hold_accepted: bool = False


def sentence(fault: str, event: Event, advice: str | None, last: Event, mode: Mode | None, done: Done) -> str:
    """``fault``: what happened first, ``event`` its kind; ``last``: what ended the flight; ``mode``: the last one that
    was heard."""
    if event is Event.STOP:
        return fault  # whoever stopped it knows the rest
    where = "an unknown mode" if mode is None else mode.words
    return f"{fault.rstrip('.')}: {_fate(last, where, done)}; {advice or ADVICE.get(event, 'see the report')}"


def _fate(last: Event, where: str, done: Done) -> str:
    """What became of the flight."""
    if not done.flew and not done.armed:
        return "nothing was flown"
    if last in FATE:
        return FATE[last].format(mode=where)
    if last is Event.HELD:
        return f"HOLD was asked for, and the vehicle is in {where}" if done.hold_asked else f"the vehicle is in {where}"
    if not done.flew:
        return f"the vehicle was armed, was last heard in {where}, and nothing more is asked of it"
    if done.hold_accepted:
        return f"HOLD was accepted, and the vehicle was last heard in {where}"
    asked = "HOLD was asked for without an answer, " if done.hold_asked else ""
    return f"{asked}setpoints have stopped, and the autopilot's own failsafe acts"
