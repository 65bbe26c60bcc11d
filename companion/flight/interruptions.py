"""Guards of what cuts in: the user, the operator, a failsafe, silence, a fault, a refusal, a time-out."""

from __future__ import annotations

from companion.flight.conduct import ControlAuthority
from companion.flight.phases import FLOWN, PHASES, TRIES, Phase
from companion.flight.safety import Action
from companion.flight.situation import Situation
from companion.mavlink_common import MavResult
from companion.vehicle import Landed, Mode

STATE_AGE_MAX = 0.2
"""s: an older state is none. Issue 11, rule 1."""
STATUS_LOST_AFTER = 2.5
"""s without a word about the mode after which setpoints end: with the level ones of an abort within 3 s. Issue 11,
rule 2."""
SILENT_AFTER = {
    **dict.fromkeys((Phase.ARM, Phase.TAKE_OFF), STATUS_LOST_AFTER),
    **dict.fromkeys((Phase.LAND, Phase.RETURN, Phase.RELEASE), 30.0),
}
"""s without a word about the mode after which nothing more is waited for: while taking off nothing more may be asked
then; once the vehicle lands by itself, the link may be away behind a tree. Engineering choice."""
ANSWER_WITHIN = 5.0
"""s after the last of TRIES after which what was neither answered nor done is not going to be. Engineering choice."""
DISARMED_FOR = 0.25
"""s after ARM was accepted, or disarming began, from which on a heartbeat that says disarmed was sent later
(engineering choice: two times the longest way that is flown with)."""
GAP_TOLD = 0.1
"""s without a new state that are told as what may be behind a failsafe: PX4 acts on lost setpoints after 0.1 s at
motors (COM_OF_LOSS_T), and without a state there is none."""
CONFIRM_WITHIN = 1.5
"""s after an accepted mode change within which telemetry must show it. Engineering choice: PX4's heartbeat alone is
1 Hz."""
OLD_MODE_WITHIN = 0.2
"""s after a mode was accepted, or first seen, in which the mode before may still be told, as it was sent before and
overtaken on the way; told later, the vehicle went back to it. Engineering choice: PX4 answers and changes within a few
ms, two times the longest way that is flown with."""
TO_THE_GROUND = (Phase.LAND, Phase.RETURN)
"""The phases in which the vehicle comes down by itself."""
BEGINS = (Phase.TAKE_OFF, Phase.LAND, Phase.RETURN)
"""The phases in which the vehicle does by itself what it was asked for."""
EXPECTED_MODES: dict[Phase, frozenset[Mode]] = {
    Phase.ARM: frozenset(),
    Phase.TAKE_OFF: frozenset({Mode.TAKEOFF, Mode.HOLD}),
    **dict.fromkeys((Phase.TAKE_OVER, *FLOWN), frozenset({Mode.OFFBOARD})),
    Phase.LAND: frozenset({Mode.LAND}),
    Phase.RETURN: frozenset({Mode.RETURN}),
}
"""The modes in which a phase goes on, beside the one it was decided in as long as its own was not seen."""


def stop(s: Situation) -> str | None:
    return "stopped by the user" if s.stop else None


def stop_on_ground(s: Situation) -> str | None:
    return "stopped by the user" if s.stop and s.status.landed is Landed.ON_GROUND else None


def elsewhere(s: Situation) -> bool:
    """Whether the vehicle is in a mode in which this phase does not go on: somebody or something decided otherwise."""
    expected, mode = EXPECTED_MODES.get(s.phase), s.status.mode
    if expected is None or mode is None or mode in expected:
        return False
    if mode is s.decided_in:
        told_late = s.answered - s.status.mode_age > OLD_MODE_WITHIN
        if not told_late or not s.mode_seen:
            return told_late and s.phase in FLOWN
    if s.phase in TO_THE_GROUND:  # PX4 leaves these modes itself when it disarms
        if s.status.landed is Landed.ON_GROUND:
            return False
        if s.status.landed is None and s.status.armed is not None and s.armed_heard > s.status.mode_age:
            return False  # only HEARTBEAT tells now whether it has landed, and comes after CURRENT_MODE
    return s.phase is Phase.ARM or s.status.armed is not False


def by_itself(s: Situation) -> bool:
    """Whether a mode that is not this phase's is the vehicle's own decision: its user's intention has not changed."""
    if s.status.intended is None:
        return bool(s.status.failsafe)
    return s.status.intended is not s.status.mode


def left_offboard(s: Situation) -> str | None:
    if s.authority is not ControlAuthority.PILOT or not elsewhere(s) or by_itself(s):
        return None
    return f"the pilot took over: the mode is {mode_words(s)} now"


def taken_over(s: Situation) -> str | None:
    if s.authority is ControlAuthority.PILOT or not elsewhere(s) or by_itself(s):
        return None
    ours = s.phase in TO_THE_GROUND or not s.mode_seen  # Hold, which we asked for ourselves
    went_back = ours and s.status.mode is s.decided_in
    if s.status.mode is Mode.OFFBOARD or went_back:
        again = f"in {s.phase.value} the vehicle says {mode_words(s)} again"
        return f"{again}: somebody selected it, or an old word came once more"
    if s.phase in TO_THE_GROUND and s.status.landed is None and s.status.armed is None:
        return f"in {s.phase.value} the vehicle says {mode_words(s)}: it has landed, or the operator took over"
    return f"the operator took over: the mode is {mode_words(s)} now"


def failsafe(s: Situation) -> str | None:
    if not elsewhere(s) or not by_itself(s):
        return None
    if s.phase not in FLOWN:
        return f"a failsafe of the vehicle flies it in {mode_words(s)} now"
    gap = without_state(s)
    behind = f", after no new state had come from it for {gap:.2f} s" if gap > GAP_TOLD else ""
    return f"the vehicle left OFFBOARD by itself, for {mode_words(s)} (a failsafe){behind}"


def disarmed_externally(s: Situation) -> str | None:
    if s.status.armed is not False:
        return None
    if s.phase is not Phase.ARM:
        return "the vehicle was disarmed"
    accepted = s.answer is not None and s.answer.accepted
    # a heartbeat that was sent after ARM was accepted
    later = s.answered - s.armed_heard > DISARMED_FOR
    return "the vehicle was disarmed after ARM was accepted" if accepted and later else None


def without_state(s: Situation) -> float:
    """s without a new state."""
    return s.now - (s.entered if s.state_at is None else s.state_at)


def stale(s: Situation) -> str | None:
    silent = without_state(s)
    if silent <= STATE_AGE_MAX:
        return None
    if s.unusable is None and s.late > 0.5 * STATE_AGE_MAX:
        return f"no state from the vehicle younger than {STATE_AGE_MAX:g} s: the last came {s.late:.2f} s late"
    if s.unusable is None:
        return f"no state from the vehicle for {silent:.2f} s"
    return f"no new state from the vehicle for {silent:.2f} s: {s.unusable}"


def status_lost(s: Situation) -> str | None:
    silent = s.status.mode_age
    if silent <= STATUS_LOST_AFTER:
        return None
    return f"the vehicle has not said its mode for {silent:.1f} s (CURRENT_MODE, HEARTBEAT)"


def silent(s: Situation) -> str | None:
    silent = s.status.mode_age
    return f"nothing heard from the vehicle for {silent:.1f} s" if silent > SILENT_AFTER[s.phase] else None


def law_failed(s: Situation) -> str | None:
    return s.law_error


def abort_required(s: Situation) -> str | None:
    return s.verdict.reason if s.verdict.action is Action.ABORT else None


def hand_back_required(s: Situation) -> str | None:
    return s.verdict.reason if s.verdict.action is Action.HAND_BACK else None


def refused(s: Situation) -> str | None:
    if s.answer is None or s.answer.accepted or s.answer.reply is MavResult.TEMPORARILY_REJECTED:
        return None
    return f"the vehicle refused {s.answer.request.value}: {s.answer.reply.words}"


def timed_out(s: Situation) -> str | None:
    row = PHASES[s.phase]
    lasted = s.now - s.entered
    if s.phase in FLOWN and s.authority is ControlAuthority.COMPANION and not s.mode_seen and lasted > CONFIRM_WITHIN:
        return f"OFFBOARD was accepted but the vehicle reports {mode_words(s)}"
    unanswered = s.asked >= TRIES and s.now - s.asked_at > ANSWER_WITHIN and (s.answer is None or not s.answer.accepted)
    if unanswered and s.phase in BEGINS and not s.mode_seen:
        told = "did not answer" if s.answer is None else f"answered {s.answer.reply.words}"
        return f"{s.phase.value} was not begun within {lasted:.0f} s: the vehicle {told}"
    if unanswered and s.phase is Phase.RELEASE and s.status.armed is False:
        return "OFFBOARD could not be ended for good: the vehicle does not answer"
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
        why = f": the vehicle accepted and reports {mode_words(s)}"
    return f"{s.phase.value} was not done within {row.time_out:g} s{why}"


def mode_words(s: Situation) -> str:
    return "no known mode" if s.status.mode is None else s.status.mode.words
