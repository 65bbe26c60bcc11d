"""How a flight ended, in one sentence: what happened, what was done, what to do next."""

from __future__ import annotations

from companion.flight.phases import Event
from companion.vehicle import Mode

ADVICE: dict[Event, str] = {
    Event.STALE: "check the link, then start again",
    Event.LAW_FAILED: "companion check says where the mission cannot be flown",
    Event.TAKEN_OVER: "start again when it is to fly the path",
    Event.FAILSAFE: "the ground station shows the failsafe's cause",
    Event.DISARMED_EXTERNALLY: "look at the vehicle before it is armed again",
    Event.REFUSED: "the ground station shows the reason",
    Event.TIMED_OUT: "put that right, then start again",
}
"""By what happened."""

FATE: dict[Event, str] = {
    Event.HELD: "HOLD was asked for, and the vehicle is in {mode}",
    Event.TAKEN_OVER: "nothing more was sent",
    Event.LET_GO: "nothing more was sent, and the vehicle is in {mode} and will not return to OFFBOARD",
    Event.DISARMED: "the vehicle is disarmed",
    Event.REFUSED: "nothing was flown",
    Event.STOP: "nothing was commanded",
    Event.LAW_FAILED: "nothing was commanded",
    Event.TIMED_OUT: "setpoints have stopped, and the autopilot's own failsafe acts",
}
"""By what ended the flight."""


def sentence(fault: str, event: Event, advice: str | None, last: Event, mode: Mode | None, flew: bool) -> str:
    """``fault``: what happened first, ``event`` its kind; ``last``: what ended the flight; ``flew``: setpoints were."""
    if event is Event.STOP:
        return fault  # whoever stopped it knows the rest
    happened = fault.rstrip(".")
    fate = FATE.get(last, "the flight was ended") if flew else "nothing was flown"
    done = fate.format(mode="an unknown mode" if mode is None else mode.words)
    return f"{happened}: {done}; {advice or ADVICE.get(event, 'see the report')}"
