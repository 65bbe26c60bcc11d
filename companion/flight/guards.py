"""What is seen -> events, each with its reason in words for the person at the field.

A guard is a pure function of the situation: it says why its event has happened, or nothing.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.flight.conduct import ControlAuthority, Finish
from companion.flight.phases import EXITS, FLOWN, PHASES, Event, Phase
from companion.flight.safety import Action
from companion.flight.situation import Reply, Situation
from companion.vehicle import Landed, Mode

STATE_AGE_MAX = 0.2
"""s: an older state is none (issue 11, rule 1)."""
STATUS_LOST_AFTER = 2.5
"""s without a word about the mode after which setpoints end: with the level ones of an abort within 3 s (rule 2)."""
SILENT_AFTER = 2.5
"""s without a word about the mode while taking off, after which nothing more is asked for."""
DISARMED_FOR = 0.25
"""s after ARM was accepted from which on a heartbeat that says disarmed was sent later (engineering choice: two times
the longest way that is flown with)."""
BEGUN_IN = (Mode.HOLD, Mode.POSITION)
"""The modes from which a flying vehicle is taken (rule 3)."""
CONFIRM_WITHIN = 1.5
"""s after an accepted mode change within which telemetry must show it (the heartbeat alone is 1 Hz)."""
STREAM_FIRST = 0.1
"""s of setpoints before OFFBOARD is asked for: PX4 refuses the mode without a stream."""


def decide(situation: Situation) -> tuple[Phase, Event, str] | None:
    """The phase that comes next, the event that brings it and its reason; None to stay."""
    for guard, event, following in _WATCHED[situation.phase]:
        reason = guard(situation)
        if reason is not None:
            return following, event, reason
    return None


EXPECTED_MODES: dict[Phase, frozenset[Mode]] = {
    Phase.ARM: frozenset(),
    Phase.TAKE_OFF: frozenset({Mode.TAKEOFF, Mode.HOLD}),
    **dict.fromkeys((Phase.TAKE_OVER, *FLOWN), frozenset({Mode.OFFBOARD})),
    Phase.LAND: frozenset({Mode.LAND}),
    Phase.RETURN: frozenset({Mode.RETURN}),
}
"""The modes in which a phase goes on, beside the one it was decided in as long as its own was not seen."""


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
    return f"the vehicle flies in {_mode(s)}, and the companion takes over only from Hold or Position"


def _ready_for_pilot(s: Situation) -> str | None:
    if s.authority is not ControlAuthority.PILOT or s.missing is not None:
        return None
    return "all is ready; the path is flown while the pilot has OFFBOARD selected"


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
        return "the pilot selected OFFBOARD" if flies else None
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
    return f"the vehicle is in {_mode(s)}"


def _held_to_land(s: Situation) -> str | None:
    return "the vehicle holds" if _left(s) and _ending(s) is Finish.LAND else None


def _held_to_return(s: Situation) -> str | None:
    return "the vehicle holds" if _left(s) and _ending(s) is Finish.RETURN else None


def _down(s: Situation) -> str | None:
    if s.status.landed is Landed.ON_GROUND or s.status.armed is False:
        return "landed"
    return None


def _disarmed(s: Situation) -> str | None:
    return "disarmed" if s.status.armed is False else None


def _let_go(s: Situation) -> str | None:
    return f"the vehicle is in {_mode(s)} and will not return to OFFBOARD" if _left(s) else None


def _stop(s: Situation) -> str | None:
    return "stopped by the user" if s.stop else None


def _elsewhere(s: Situation) -> bool:
    """Whether the vehicle is in a mode in which this phase does not go on: somebody or something decided otherwise."""
    expected, mode = EXPECTED_MODES.get(s.phase), s.status.mode
    if expected is None or mode is None or mode in expected:
        return False
    if mode is s.decided_in and not s.mode_seen:
        return False
    if s.phase in (Phase.LAND, Phase.RETURN) and s.status.landed is Landed.ON_GROUND:
        return False  # PX4 leaves these modes itself when it disarms
    return s.phase is Phase.ARM or s.status.armed is not False


def _by_itself(s: Situation) -> bool:
    """Whether a mode that is not this phase's is the vehicle's own decision: its user's intention has not changed."""
    if s.status.intended is None:
        return bool(s.status.failsafe)
    return s.status.intended is not s.status.mode


def _left_offboard(s: Situation) -> str | None:
    if s.authority is not ControlAuthority.PILOT or not _elsewhere(s) or _by_itself(s):
        return None
    return f"the pilot took over: the mode is {_mode(s)} now"


def _taken_over(s: Situation) -> str | None:
    if s.authority is ControlAuthority.PILOT or not _elsewhere(s) or _by_itself(s):
        return None
    return f"the operator took over: the mode is {_mode(s)} now"


def _failsafe(s: Situation) -> str | None:
    if not _elsewhere(s) or not _by_itself(s):
        return None
    if s.phase not in FLOWN:
        return f"a failsafe of the vehicle flies it in {_mode(s)} now"
    return f"the vehicle left OFFBOARD by itself, for {_mode(s)} (a failsafe)"


def _disarmed_externally(s: Situation) -> str | None:
    if s.status.armed is not False:
        return None
    if s.phase is not Phase.ARM:
        return "the vehicle was disarmed"
    accepted = s.answer is not None and s.answer.accepted
    # a heartbeat that was sent after ARM was accepted
    later = s.answered - s.armed_heard > DISARMED_FOR
    return "the vehicle was disarmed after ARM was accepted" if accepted and later else None


def _stale(s: Situation) -> str | None:
    since = s.entered if s.state_at is None else s.state_at
    silent = s.now - since
    if silent <= STATE_AGE_MAX:
        return None
    if s.unusable is None and s.late > 0.5 * STATE_AGE_MAX:
        return f"no state from the vehicle younger than {STATE_AGE_MAX:g} s: they come {s.late:.2f} s late"
    if s.unusable is None:
        return f"no state from the vehicle for {silent:.2f} s"
    return f"no new state from the vehicle for {silent:.2f} s: {s.unusable}"


def _status_lost(s: Situation) -> str | None:
    silent = s.status.mode_age
    if silent <= STATUS_LOST_AFTER:
        return None
    return f"the vehicle has not said its mode for {silent:.1f} s (CURRENT_MODE, HEARTBEAT)"


def _silent(s: Situation) -> str | None:
    silent = s.status.mode_age
    return f"nothing heard from the vehicle for {silent:.1f} s" if silent > SILENT_AFTER else None


def _law_failed(s: Situation) -> str | None:
    return s.law_error


def _abort_required(s: Situation) -> str | None:
    return s.verdict.reason if s.verdict.action is Action.ABORT else None


def _hand_back_required(s: Situation) -> str | None:
    return s.verdict.reason if s.verdict.action is Action.HAND_BACK else None


def _refused(s: Situation) -> str | None:
    if s.answer is None or s.answer.accepted or s.answer.reply is Reply.TEMPORARILY_REJECTED:
        return None
    return f"the vehicle refused {s.answer.request.value}: {s.answer.reply.words}"


def _timed_out(s: Situation) -> str | None:
    row = PHASES[s.phase]
    lasted = s.now - s.entered
    if s.phase in FLOWN and s.authority is ControlAuthority.COMPANION and not s.mode_seen and lasted > CONFIRM_WITHIN:
        return f"OFFBOARD was accepted but the vehicle reports {_mode(s)}"
    if row.time_out is None or lasted <= row.time_out:
        return None
    if s.phase is Phase.HAND_BACK and s.authority is ControlAuthority.PILOT:
        return None  # it is held until the pilot has it
    why = ""
    if s.phase is Phase.PREFLIGHT:
        why = f": {s.missing or 'the vehicle neither stands disarmed nor flies'}"
    elif s.phase is Phase.SETTLE:
        why = ": the thrust that carries the vehicle was not found"
    elif s.answer is not None and not s.answer.accepted:
        why = f": the vehicle answered {s.answer.reply.words}"
    elif row.request is not None and s.answer is None:
        why = ": the vehicle did not answer" if s.asked else ": its mode was not known, so nothing was asked of it"
    elif s.phase is Phase.ABORT:
        why = f": the vehicle accepted and reports {_mode(s)}"
    return f"{s.phase.value} was not done within {row.time_out:g} s{why}"


def _mode(s: Situation) -> str:
    return "no known mode" if s.status.mode is None else s.status.mode.words


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
    Event.STOP: _stop,
    Event.LEFT_OFFBOARD: _left_offboard,
    Event.TAKEN_OVER: _taken_over,
    Event.FAILSAFE: _failsafe,
    Event.DISARMED_EXTERNALLY: _disarmed_externally,
    Event.STALE: _stale,
    Event.STATUS_LOST: _status_lost,
    Event.SILENT: _silent,
    Event.LAW_FAILED: _law_failed,
    Event.ABORT_REQUIRED: _abort_required,
    Event.HAND_BACK_REQUIRED: _hand_back_required,
    Event.REFUSED: _refused,
    Event.TIMED_OUT: _timed_out,
}

_WATCHED = {
    phase: tuple((GUARDS[event], event, following) for event, following in exits) for phase, exits in EXITS.items()
}
"""What a phase looks at, the most urgent first."""
