"""What is seen -> events, each with its reason in words for the person at the field.

A guard is a pure function of the situation: it says why its event has happened, or nothing.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.interruptions import (
    DISARMED_FOR,
    abort_required,
    disarmed_externally,
    failsafe,
    hand_back_required,
    law_failed,
    left_offboard,
    mode_words,
    refused,
    silent,
    stale,
    status_lost,
    stop,
    stop_on_ground,
    taken_over,
    timed_out,
)
from companion.flight.phases import EXITS, Event, Phase
from companion.flight.situation import Situation
from companion.vehicle import Landed, Mode

BEGUN_IN = (Mode.HOLD, Mode.POSITION)
"""The modes from which a flying vehicle is taken (rule 3)."""
STREAM_FIRST = 0.1
"""s of setpoints before OFFBOARD is asked for: PX4 refuses the mode without a stream."""


def decide(situation: Situation) -> tuple[Phase, Event, str] | None:
    """The phase that comes next, the event that brings it and its reason; None to stay."""
    for guard, event, following in _WATCHED[situation.phase]:
        reason = guard(situation)
        if reason is not None:
            return following, event, reason
    return None


def _ready_on_ground(s: Situation) -> str | None:
    on_ground = s.status.landed is Landed.ON_GROUND and s.status.armed is False and s.status.mode is not None
    if s.authority is not ControlAuthority.COMPANION or s.missing is not None or not on_ground or s.status.was_armed:
        return None
    return "the vehicle is ready on the ground"


def _ready_in_air(s: Situation) -> str | None:
    flies = s.status.armed and s.status.landed is Landed.IN_AIR and s.status.mode in BEGUN_IN
    if s.authority is not ControlAuthority.COMPANION or s.missing is not None or not flies:
        return None
    return "the vehicle is flying"


def _not_ours(s: Situation) -> str | None:
    """Why a flight that the companion begins must not begin: the vehicle is, or was, in somebody else's hands."""
    status = s.status
    if s.authority is not ControlAuthority.COMPANION or status.landed in (None, Landed.UNDEFINED):
        return None
    if status.landed is Landed.ON_GROUND:
        if status.armed is False and status.was_armed:
            return "the vehicle was armed by somebody else since the companion first heard it, so it is not armed here"
        return None
    if not status.armed or status.mode is None or status.mode in BEGUN_IN:
        return None
    return f"the vehicle flies in {mode_words(s)}, and the companion takes over only from Hold or Position"


def _ready_for_pilot(s: Situation) -> str | None:
    if s.authority is not ControlAuthority.PILOT or s.missing is not None:
        return None
    return f"all is ready; the path is flown while the pilot has {s.flown_in} selected"


def _ready_to_rehearse(s: Situation) -> str | None:
    if s.authority not in (ControlAuthority.REHEARSAL, ControlAuthority.BENCH) or s.missing is not None:
        return None
    return "all is ready; nothing is armed and nothing commanded"


def _armed(s: Situation) -> str | None:
    return "armed" if s.status.armed and s.asked else None


def _in_air(s: Situation) -> str | None:
    if s.status.landed is Landed.IN_AIR and s.status.mode is Mode.HOLD and s.mode_seen:
        return "taken off"
    return None


def _in_offboard(s: Situation) -> str | None:
    if s.authority is ControlAuthority.PILOT:
        flies = s.status.armed and s.status.landed is Landed.IN_AIR and s.status.mode is Mode.OFFBOARD
        return f"the pilot selected {s.flown_in}" if flies else None
    # an accepted change is the vehicle's word as much as a heartbeat is, and up to a second earlier
    if s.status.mode is Mode.OFFBOARD or (s.answer is not None and s.answer.accepted):
        return "OFFBOARD accepted"
    return None


def _settled(s: Situation) -> str | None:
    return "the thrust is known" if s.settled else None


def _joined(s: Situation) -> str | None:
    return "at the path" if s.joined else None


def _at_end(s: Situation) -> str | None:
    return "the end of the path" if s.at_end else None


def _turned(s: Situation) -> str | None:
    return "flying back" if s.joined and s.goes_back else None


def _finished(s: Situation) -> str | None:
    return s.finished


def _left(s: Situation) -> bool:
    """Whether the vehicle is out of OFFBOARD for good: neither in it nor meant to be."""
    if s.status.mode in (None, Mode.OFFBOARD) or s.status.intended is Mode.OFFBOARD:
        return False
    return s.status.intended is not None or not s.status.failsafe


def _ending(s: Situation) -> Finish:
    if s.stop or s.faulty or s.authority is not ControlAuthority.COMPANION or s.status.mode is not Mode.HOLD:
        return Finish.HOLD
    if s.finish is Finish.AS_BEGUN:
        return Finish.LAND if s.from_ground else Finish.HOLD
    return s.finish


def _held(s: Situation) -> str | None:
    if not _left(s) or (s.phase is Phase.HAND_BACK and _ending(s) is not Finish.HOLD):
        return None
    return f"the vehicle is in {mode_words(s)}"


def _held_to_land(s: Situation) -> str | None:
    return "the vehicle holds" if _left(s) and _ending(s) is Finish.LAND else None


def _held_to_return(s: Situation) -> str | None:
    return "the vehicle holds" if _left(s) and _ending(s) is Finish.RETURN else None


def _down(s: Situation) -> str | None:
    if s.status.landed is Landed.ON_GROUND or s.status.armed is False:
        return "landed"
    return None


def _disarmed(s: Situation) -> str | None:
    # a heartbeat that was sent since: the one before may be older than an ARM that was accepted
    since = s.now - s.armed_heard > s.entered + DISARMED_FOR
    return "disarmed" if s.status.armed is False and since else None


def _let_go(s: Situation) -> str | None:
    return f"the vehicle is in {mode_words(s)} and will not return to OFFBOARD" if _left(s) else None


GUARDS: dict[Event, Callable[[Situation], str | None]] = {
    Event.READY_ON_GROUND: _ready_on_ground,
    Event.READY_IN_AIR: _ready_in_air,
    Event.READY_FOR_PILOT: _ready_for_pilot,
    Event.READY_TO_REHEARSE: _ready_to_rehearse,
    Event.ARMED: _armed,
    Event.IN_AIR: _in_air,
    Event.IN_OFFBOARD: _in_offboard,
    Event.SETTLED: _settled,
    Event.JOINED: _joined,
    Event.AT_END: _at_end,
    Event.TURNED: _turned,
    Event.FINISHED: _finished,
    Event.HELD: _held,
    Event.HELD_TO_LAND: _held_to_land,
    Event.HELD_TO_RETURN: _held_to_return,
    Event.DOWN: _down,
    Event.DISARMED: _disarmed,
    Event.LET_GO: _let_go,
    Event.NOT_OURS: _not_ours,
    Event.STOP_ON_GROUND: stop_on_ground,
    Event.STOP: stop,
    Event.LEFT_OFFBOARD: left_offboard,
    Event.TAKEN_OVER: taken_over,
    Event.FAILSAFE: failsafe,
    Event.DISARMED_EXTERNALLY: disarmed_externally,
    Event.STALE: stale,
    Event.STATUS_LOST: status_lost,
    Event.SILENT: silent,
    Event.LAW_FAILED: law_failed,
    Event.ABORT_REQUIRED: abort_required,
    Event.HAND_BACK_REQUIRED: hand_back_required,
    Event.REFUSED: refused,
    Event.TIMED_OUT: timed_out,
}

_WATCHED = {
    phase: tuple((GUARDS[event], event, following) for event, following in exits) for phase, exits in EXITS.items()
}
"""What a phase looks at, the most urgent first."""
