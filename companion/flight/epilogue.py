"""How a flight ended, in one sentence: what happened, what was done, what to do next."""

from __future__ import annotations

from typing import NamedTuple

from companion.flight.phases import Event, Phase
from companion.vehicle import Mode

ADVICE: dict[Event, str] = {
    Event.STALE: "check the link, then start again",
    Event.STATUS_LOST: "check the link, take the vehicle by remote control, then start again",
    Event.SILENT: "it goes on as it was commanded: watch it, take it by remote control, and check the link",
    Event.NOT_OURS: "put it in Hold or Position, or on the ground, then start again",
    Event.LAW_FAILED: "companion check says where the mission cannot be flown",
    Event.TAKEN_OVER: "start again when it is to fly the path",
    Event.FAILSAFE: "the ground station shows the failsafe's cause",
    Event.DISARMED_EXTERNALLY: "look at the vehicle before it is armed again",
    Event.REFUSED: "the ground station shows the reason",
    Event.TIMED_OUT: "put that right, then start again",
}
"""By what happened."""

ADVICE_AFTERWARDS: dict[Phase, str] = {
    Phase.LAND: "land it by remote control or from the ground station",
    Phase.RETURN: "land it by remote control or from the ground station",
    Phase.DISARM: "disarm it before anybody walks up to it",
}
"""Where the vehicle did not do the last things of a flight."""

UNHEARD = frozenset({Event.SILENT, Event.STALE, Event.STATUS_LOST})
"""What became of the last request was not heard."""

LEFT_ALONE = frozenset({Event.TAKEN_OVER, Event.FAILSAFE, Event.DISARMED_EXTERNALLY})
"""Somebody else decided."""


class Done(NamedTuple):
    """What was done in a flight, as far as it was heard."""

    begun: bool = False  # OFFBOARD was asked for, which may have been taken unheard
    flew: bool = False  # in OFFBOARD, on our setpoints
    armed: bool = False  # by us
    left: bool = False  # it was seen to go on by itself
    hold_asked: int = 0  # times
    hold_accepted: bool = False
    arm_asked: bool = False  # which may have been taken unheard


def sentence(fault: str, event: Event, advice: str | None, last: Event, mode: Mode | None, done: Done) -> str:
    """``fault``: what happened first, ``event`` its kind; ``last``: what ended the flight; ``mode``: the last one that
    was heard."""
    if event in (Event.STOP, Event.STOP_ON_GROUND):
        return fault  # whoever stopped it knows the rest
    where = "an unknown mode" if mode is None else mode.words
    return f"{fault.rstrip('.')}: {_fate(event, last, where, done)}; {advice or ADVICE.get(event, 'see the report')}"


def _fate(event: Event, last: Event, where: str, done: Done) -> str:
    """What became of the flight."""
    if not done.flew and not done.armed:
        if done.arm_asked and not done.begun and event in UNHEARD:
            return "it had been asked to arm and may have done so unheard"
        if not done.begun or event is Event.REFUSED:
            return "nothing was flown"
        return f"OFFBOARD had been asked for, setpoints have stopped, and the vehicle was last heard in {where}"
    if last is Event.TAKEN_OVER:
        return "nothing more was sent"
    if last is Event.DISARMED:
        return "the vehicle is disarmed"
    if last is Event.LET_GO:
        if done.hold_asked:
            return f"HOLD was asked for to end OFFBOARD, and the vehicle is in {where} and will not return to it"
        kept = "nothing more was sent, and " if event in LEFT_ALONE else ""
        return f"{kept}the vehicle is in {where} and will not return to OFFBOARD"
    if last is Event.HELD:
        return f"HOLD was asked for, and the vehicle is in {where}" if done.hold_asked else f"the vehicle is in {where}"
    if not done.flew:
        return f"the vehicle was armed, was last heard in {where}, and nothing more is asked of it"
    if done.left and where == Mode.OFFBOARD.words:
        return f"it was last heard in {where}, and HOLD was not answered: select another mode before it is armed again"
    if done.left:
        return f"the vehicle was last heard in {where}, and nothing more is asked of it"
    if done.hold_accepted:
        return f"HOLD was accepted, and the vehicle was last heard in {where}"
    asked = "HOLD was asked for without an answer, " if done.hold_asked else ""
    return f"{asked}setpoints have stopped, and the autopilot's own failsafe acts"
