"""A flight against its case: what is not as it must be, in words."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from companion.mavlink.modes import Mode
from companion.world.events import Order
from sim_bridge.strangers import MODES
from trials.faults.case import End
from trials.faults.course import Flight
from trials.faults.rules import broken, commands_after, last_words

HALF = 0.5
"""The share of its height that no flight may lose unless its thrust is gone."""


def wrong(flight: Flight) -> list[str]:
    """Everything that is not as the case says, and every rule that is broken."""
    case = flight.case
    ends = (case.end, *case.or_end)
    found = broken(flight)
    if not any(_ended(flight, end) for end in ends):
        expected = " or ".join(end.value for end in ends)
        found.append(f"ends otherwise than {expected}: {_state_in_words(flight)}")
    if case.says and not (flight.completed and End.FLOWN in ends) and not re.search(case.says, flight.sentence or ""):
        found.append(f"says {flight.sentence!r}, expected {case.says!r}")
    if flight.event_at is None and (case.events or case.strikes):
        found.append("nothing happened: the phase it waits for never began")
    return found + list(_out_of_bounds(flight))


def commands_after_the_last_word(flight: Flight) -> int | None:
    """How many commands the companion sent after it had heard the operator's last word; None: he said nothing."""
    words = last_words(flight)
    return len(commands_after(flight, words[-1])) if words else None


def _ended(flight: Flight, end: End) -> bool:
    """Whether a flight ended so."""
    over = flight.done_at is not None and not flight.completed
    match end:
        case End.FLOWN:
            return flight.completed
        case End.HELD | End.FAILSAFE:
            return flight.is_left_to_failsafe or (over and flight.armed and flight.mode is Mode.HOLD)
        case End.REFUSED:
            return over and not flight.traffic.commands and bool(flight.sentence)
        case End.OPERATORS:
            return over and bool(flight.words) and _obeyed_order(flight)
        case End.ENDED:
            return over and bool(flight.sentence)
        case End.DISARMED:
            return over and bool(flight.sentence) and not flight.armed
    raise AssertionError(end)


def _obeyed_order(flight: Flight) -> bool:
    """Whether the vehicle does, or has done, what its operator said last."""
    order = flight.words[-1].order.order
    if order in (Order.DISARM, Order.KILL, Order.TERMINATE):
        return not flight.armed
    return flight.mode is MODES[order] or (order in (Order.LAND, Order.RETURN) and not flight.armed)


def end_in_words(flight: Flight) -> str:
    """How a flight ended: as the case says where it did, else in the words of the first end that fits."""
    case = flight.case
    order = (case.end, *case.or_end, End.FLOWN, End.REFUSED, End.OPERATORS, End.HELD, End.ENDED)
    return next((end.value for end in order if _ended(flight, end)), "not over")


def _state_in_words(flight: Flight) -> str:
    if flight.done_at is None:
        return f"not over after {flight.entered[-1][1] if flight.entered else 0:.0f} s in {flight.entered[-1:]}"
    state = f"{flight.mode.words}, {'armed' if flight.armed else 'disarmed'}"
    return f"{'completed' if flight.completed else flight.sentence!r}, {len(flight.traffic.commands)} commands; {state}"


def _out_of_bounds(flight: Flight) -> Iterator[str]:
    case = flight.case
    if not case.loses_thrust:
        lost = flight.height_then - flight.lowest
        most = HALF * flight.height_then if case.lost_max is None else case.lost_max
        if math.isfinite(flight.lowest) and lost > most:
            yield f"{lost:.1f} m lower than the {flight.height_then:.1f} m it flew at"
        angle = math.degrees(flight.steepest)
        if angle > case.tilt_max:
            yield f"tilts by {angle:.0f} degrees"
    if case.within is not None and flight.event_at is not None:
        noticed = math.inf if flight.noticed_at is None else flight.noticed_at - flight.event_at
        if noticed > case.within:
            yield f"noticed after {noticed:.2f} s, expected {case.within:g}"
