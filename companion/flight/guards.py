"""What is seen -> events, each with its reason in words for the person at the field.

A guard is a pure function of the situation: it says why its event has happened, or nothing.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from typing import NamedTuple

from companion.flight.phases import EXITS, PHASES, Event, Phase, Request
from companion.vehicle import Landed, Mode, VehicleStatus

STALE_AFTER = 0.2
"""s without a state before it is stale."""
CONFIRM_WITHIN = 1.5
"""s after an accepted mode change within which telemetry must show it (the heartbeat alone is 1 Hz)."""
STREAM_FIRST = 0.1
"""s of setpoints before OFFBOARD is asked for: PX4 refuses the mode without a stream."""


class Reply(enum.Enum):
    """How a vehicle answers a request (MAV_RESULT)."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5
    CANCELLED = 6

    @property
    def words(self) -> str:
        """As a sentence says it."""
        return self.name.lower().replace("_", " ")


class Answer(NamedTuple):
    """The vehicle's answer to a request."""

    request: Request
    reply: Reply

    @property
    def accepted(self) -> bool:
        """Whether the vehicle does it, or is about to."""
        return self.reply in (Reply.ACCEPTED, Reply.IN_PROGRESS)


class Situation(NamedTuple):
    """What the guards look at.

    ``now``, ``entered``: s, our clock, and since when the phase lasts. ``status``: what the vehicle said.
    ``mode_seen``: the mode of this phase was seen in telemetry. ``state_at``: when the last state arrived.
    ``answer``: the last answer to this phase's request. ``from_ground``: the flight began on the ground and is to end
    there. ``stop``: told to stop. ``finished``, ``law_error``: reasons, or None.
    """

    phase: Phase
    now: float
    entered: float
    status: VehicleStatus
    mode_seen: bool
    state_at: float | None
    answer: Answer | None
    from_ground: bool
    stop: bool = False
    finished: str | None = None
    law_error: str | None = None


def decide(situation: Situation) -> tuple[Phase, Event, str] | None:
    """The phase that comes next, the event that brings it and its reason; None to stay."""
    for event, following in EXITS[situation.phase]:
        reason = GUARDS[event](situation)
        if reason is not None:
            return following, event, reason
    return None


EXPECTED_MODES: dict[Phase, frozenset[Mode]] = {
    Phase.TAKE_OFF: frozenset({Mode.TAKEOFF, Mode.HOLD}),
    Phase.FOLLOW: frozenset({Mode.OFFBOARD}),
    Phase.LAND: frozenset({Mode.LAND}),
}
"""The modes in which a phase that has seen its mode goes on."""


def _ready_on_ground(s: Situation) -> str | None:
    if s.state_at is None or not s.status.ready or s.status.landed is not Landed.ON_GROUND or s.status.armed:
        return None
    return "the vehicle is ready on the ground"


def _ready_in_air(s: Situation) -> str | None:
    if s.state_at is None or not s.status.armed or s.status.landed is not Landed.IN_AIR:
        return None
    return "the vehicle is flying"


def _armed(s: Situation) -> str | None:
    return "armed" if s.status.armed else None


def _in_air(s: Situation) -> str | None:
    if s.status.landed is Landed.IN_AIR and s.status.mode is Mode.HOLD and s.mode_seen:
        return "taken off"
    return None


def _in_offboard(s: Situation) -> str | None:
    # an accepted change is the vehicle's word as much as a heartbeat is, and up to a second earlier
    if s.status.mode is Mode.OFFBOARD or (s.answer is not None and s.answer.accepted):
        return "OFFBOARD accepted"
    return None


def _finished(s: Situation) -> str | None:
    return s.finished


def _held(s: Situation) -> str | None:
    handed_back = s.status.mode not in (None, Mode.OFFBOARD)
    lands = s.from_ground and not s.stop and s.status.mode is Mode.HOLD
    return f"the vehicle is in {_mode(s)}" if handed_back and not lands else None


def _held_to_land(s: Situation) -> str | None:
    lands = s.from_ground and not s.stop and s.status.mode is Mode.HOLD
    return "the vehicle holds" if lands else None


def _down(s: Situation) -> str | None:
    if s.status.landed is Landed.ON_GROUND or s.status.armed is False:
        return "landed"
    return None


def _disarmed(s: Situation) -> str | None:
    return "disarmed" if s.status.armed is False else None


def _stop(s: Situation) -> str | None:
    return "stopped by the user" if s.stop else None


def _taken_over(s: Situation) -> str | None:
    expected = EXPECTED_MODES.get(s.phase)
    if expected is None or not s.mode_seen or s.status.mode in expected or s.status.mode is None:
        return None
    if s.status.armed is False:
        return None
    if s.phase is Phase.FOLLOW and (s.status.failsafe or s.status.intended is Mode.OFFBOARD):
        return f"the vehicle left OFFBOARD by itself, for {_mode(s)} (a failsafe); it flies itself now"
    return f"the operator took over: the mode is {_mode(s)} now"


def _lost_power(s: Situation) -> str | None:
    return "the vehicle was disarmed" if s.status.armed is False and s.phase is not Phase.PREFLIGHT else None


def _stale(s: Situation) -> str | None:
    since = s.entered if s.state_at is None else s.state_at
    silent = s.now - since
    return f"no state from the vehicle for {silent:.2f} s" if silent > STALE_AFTER else None


def _law_failed(s: Situation) -> str | None:
    return s.law_error


def _refused(s: Situation) -> str | None:
    if s.answer is None or s.answer.accepted or s.answer.reply is Reply.TEMPORARILY_REJECTED:
        return None
    return f"the vehicle refused {s.answer.request.value}: {s.answer.reply.words}"


def _timed_out(s: Situation) -> str | None:
    row = PHASES[s.phase]
    lasted = s.now - s.entered
    if s.phase is Phase.FOLLOW:
        if not s.mode_seen and lasted > CONFIRM_WITHIN:
            return f"OFFBOARD was accepted but the vehicle reports {_mode(s)}"
        return None
    if row.time_out is None or lasted <= row.time_out:
        return None
    why = ""
    if s.phase is Phase.PREFLIGHT:
        why = ": " + (
            "no state arrives"
            if s.state_at is None
            else "the vehicle says it is not ready to arm"
            if not s.status.ready
            else "it does not say whether it stands or flies"
        )
    elif s.answer is not None and not s.answer.accepted:
        why = f": the vehicle answered {s.answer.reply.words}"
    elif row.request is not None and s.answer is None:
        why = ": the vehicle did not answer"
    return f"{s.phase.value} was not done within {row.time_out:g} s{why}"


def _mode(s: Situation) -> str:
    return "no known mode" if s.status.mode is None else s.status.mode.words


GUARDS: dict[Event, Callable[[Situation], str | None]] = {
    Event.READY_ON_GROUND: _ready_on_ground,
    Event.READY_IN_AIR: _ready_in_air,
    Event.ARMED: _armed,
    Event.IN_AIR: _in_air,
    Event.IN_OFFBOARD: _in_offboard,
    Event.FINISHED: _finished,
    Event.HELD: _held,
    Event.HELD_TO_LAND: _held_to_land,
    Event.DOWN: _down,
    Event.DISARMED: _disarmed,
    Event.STOP: _stop,
    Event.TAKEN_OVER: _taken_over,
    Event.LOST_POWER: _lost_power,
    Event.STALE: _stale,
    Event.LAW_FAILED: _law_failed,
    Event.REFUSED: _refused,
    Event.TIMED_OUT: _timed_out,
}
