"""What no flight may do, whatever happens to it. Each rule looks at a flight and says what is broken, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator

from companion.flight.conduct import ControlAuthority
from companion.flight.interruptions import OLD_MODE_WITHIN
from companion.flight.phases import Phase
from companion.mavlink.modes import Mode
from companion.world.events import LinkDelay, LinkEvent, Operator, Order, PortChange, Sticks, Stranger
from sim_bridge.strangers import MODES
from trials.faults.course import Flight, Word

STATUS_AGE_MAX = 1.0
"""s after the vehicle last spoke of its mode in which a mode, arming or a place may still be asked for."""
SAME_MODE_MAX = 3
"""How often HOLD may be asked for on the ground because OFFBOARD is still meant (PX4 goes back to it by itself)."""
MARGIN = 0.02
"""s: five steps of the plant, for what was decided when the state arrived and left just after."""
ANSWERED_WITHIN = 0.2
"""s there and back, at most, on a link that is flown with."""
NOT_A_WORD = frozenset({Order.ARM, Order.TAKE_OFF, Order.OFFBOARD, Order.MISSION, Order.TERMINATE})
"""Orders that do not take the vehicle from the companion, or that the stand-in does not keep."""
HEARTBEAT = frozenset({"HEARTBEAT"})
STOPS_THE_MOTORS = frozenset({Order.DISARM, Order.KILL, Order.TERMINATE})
BEFORE = (None, Phase.PREFLIGHT)
"""What the companion does before its flight begins."""
ASKS_FOR_HOLD = (Phase.HAND_BACK, Phase.ABORT, Phase.RELEASE)


def broken(flight: Flight) -> list[str]:
    """Every rule the flight broke."""
    return [
        *(f"a bad setpoint: {words}" for words in flight.traffic.bad[:3]),
        *([] if flight.done_at is not None or flight.is_left_to_failsafe else ["not over in time"]),
        *_blind_commands(flight),
        *(words for word in last_words(flight) for words in _against(flight, word)),
        *_unasked(flight),
        *_false_words(flight),
    ]


def last_words(flight: Flight) -> list[Word]:
    """What the operator said that the companion may not go against: neither what begins a flight nor what it asks for
    itself."""
    return [word for word in flight.words if not _is_ours(word) and not _is_already_so(flight, word)]


def _is_already_so(flight: Flight, word: Word) -> bool:
    """Whether he selects the mode that the vehicle is in, before it takes the one that was asked for: nothing shows that
    he did."""
    waits = word.phase in (Phase.ARM, Phase.TAKE_OVER, Phase.LAND, Phase.RETURN)
    return waits and _selects_mode_heard(flight, word, word.at)


def _is_ours(word: Word) -> bool:
    order = word.order.order
    if order in NOT_A_WORD:
        return True
    if word.phase in BEFORE:
        return order in (Order.HOLD, Order.POSITION, Order.DISARM, Order.KILL)
    if order is Order.HOLD:
        return word.phase in ASKS_FOR_HOLD
    return (order, word.phase) in ((Order.LAND, Phase.LAND), (Order.RETURN, Phase.RETURN)) or word.phase is Phase.DONE


def seen_at(flight: Flight, word: Word) -> float:
    """When the companion heard of it: the first state after the first status that shows it. Infinity: it never did."""
    order = word.order.order
    old_until = -math.inf if order in STOPS_THE_MOTORS else _old_until(flight, word)
    for heard in flight.traffic.statuses:
        if heard.at <= word.at or heard.at < old_until:
            continue
        if heard.armed is False if order in (Order.DISARM, Order.KILL) else heard.mode is MODES[order]:
            return flight.traffic.state_after(heard.at) + MARGIN
    return math.inf


def _old_until(flight: Flight, word: Word) -> float:
    """Until when his mode may be the one before a mode that was asked for, told late; -infinity: it is another one."""
    asked = [said for said in flight.traffic.commands if said.mode is not None and said.at < word.at]
    if not asked or not _selects_mode_heard(flight, word, asked[-1].at):
        return -math.inf
    at, mode = asked[-1].at, asked[-1].mode
    seen = next((heard.at for heard in flight.traffic.statuses if heard.at > at and heard.mode is mode), at)
    return max(at + ANSWERED_WITHIN, seen) + OLD_MODE_WITHIN + MARGIN


def _selects_mode_heard(flight: Flight, word: Word, at: float) -> bool:
    """Whether he selects the mode that the vehicle last said until ``at``."""
    heard = flight.traffic.last_status(at)
    return heard is not None and heard.mode is MODES.get(word.order.order)


def commands_after(flight: Flight, word: Word) -> list[str]:
    """What the companion asked for after it had heard, against the word."""
    seen, until = seen_at(flight, word), _next_word(flight, word)
    after = [said for said in flight.traffic.commands if seen < said.at < until]
    if word.order.order in (Order.DISARM, Order.KILL):
        holds = [said for said in after if said.mode is Mode.HOLD]
        if len(holds) <= SAME_MODE_MAX:
            after = [said for said in after if said not in holds]
    return [f"{said.words} at {said.at:.2f} s" for said in after]


def setpoints_after(flight: Flight, word: Word) -> int:
    """How many setpoints it sent after it had heard; the pilot's start streams them in every mode."""
    if flight.case.authority is not ControlAuthority.COMPANION:
        return 0
    seen, until = seen_at(flight, word), _next_word(flight, word)
    return sum(seen < t < until for t in flight.traffic.setpoints_at)


def _next_word(flight: Flight, word: Word) -> float:
    return min((other.at for other in flight.words if other.at > word.at), default=math.inf)


def _against(flight: Flight, word: Word) -> Iterator[str]:
    what = f"after the operator's {word.order.order.value} at {word.at:.2f} s in {word.phase and word.phase.value}"
    commands = commands_after(flight, word)
    if commands:
        yield f"{what}: {len(commands)} commands, {', '.join(commands[:3])}"
    setpoints = setpoints_after(flight, word)
    if setpoints:
        yield f"{what}: {setpoints} setpoints"


def _blind_commands(flight: Flight) -> Iterator[str]:
    """Nothing is asked for when the vehicle has not spoken of its mode for a second."""
    blind = [
        said
        for said in flight.traffic.commands
        if said.at - flight.traffic.status_before(said.at) > STATUS_AGE_MAX + MARGIN
    ]
    if blind:
        first = blind[0]
        age = first.at - flight.traffic.status_before(first.at)
        yield f"{len(blind)} commands without knowing the mode, the first {first.words} {age:.1f} s after the last status"


def _unasked(flight: Flight) -> Iterator[str]:
    """Only the companion's own start arms and changes modes."""
    if flight.case.authority is not ControlAuthority.COMPANION and flight.traffic.commands:
        yield f"{len(flight.traffic.commands)} commands in a flight that asks for nothing"


def _false_words(flight: Flight) -> Iterator[str]:
    """What is said at the end is so."""
    said, traffic = flight.sentence or "", flight.traffic
    arming = next((command.at for command in traffic.commands if command.words == "ARM"), math.inf)
    if "nothing was flown" in said and any(heard.armed and heard.at > arming for heard in traffic.statuses):
        yield f"says that nothing was flown, and had armed: {said}"
    events = (*flight.case.events, *(event for strike in flight.case.strikes for event in strike.events))
    acted = flight.words or any(isinstance(event, Sticks) for event in events)
    # a HEARTBEAT has no stamp: one that comes late while all else is in time is not told from a new one
    late = any(isinstance(event, LinkDelay) and event.down and event.messages == HEARTBEAT for event in events)
    took_over = said.startswith(("the operator took over", "the pilot took over"))
    if took_over and not acted and not late and not flight.mutated:
        yield f"says what no operator did: {said}"
    only_the_link = all(
        isinstance(event, LinkEvent | Stranger | PortChange)
        or (isinstance(event, Operator) and event.order not in STOPS_THE_MOTORS)
        for event in events
    )
    # setpoints that are lost, or that come again, look like motors that do not answer: a sentence names both
    if "propeller" in said and "link up" not in said and only_the_link and not flight.mutated:
        yield f"names the propellers where the link was the cause: {said}"
