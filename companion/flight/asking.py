"""How a vehicle is asked for something: on fresh knowledge, three times at most, and never against somebody's word.

An ``Asking`` belongs to one phase. It remembers the mode in which it was decided; where another one is seen, somebody
decided otherwise, and nothing more is asked. It ends for good with an acceptance. Whatever is sent,
``update_asking`` said so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.flight.phases import TRIES, Phase, Request
from companion.flight.situation import Answer
from companion.vehicle import KnownStatus, Landed, Mode

RETRY = 0.5
"""s between two tries: three lie within 1.5 s. Issue 11, rule 2."""
RETRY_HOLD = 0.35
"""s between two tries of HOLD in an abort: three lie within the second after the last status. Issue 11, rule 2."""
FRESH = 1.0
"""s: how old the last word about the mode may be when something is asked for. Issue 11, rule 2; PX4 says its mode
twice a second, and at once when it changes."""
FRESH_LOST = 0.3
"""s, the same when HOLD is first asked for because no state comes any more. Issue 11, rule 2."""
BACK_AFTER = 1.5
"""s without a mode after which the link was away: when it is back, HOLD may be asked for three times more. Issue 11,
rule 2."""


class Asking(NamedTuple):
    """What a phase asks for. ``mode``: in which it was decided, None where it was not known; ``own``: what we asked for
    ourselves, and may come yet. ``tries``: how often it was sent, ``sent_at``: s, when last. ``was_away``: the link
    was, since the last try; ``again``: HOLD was given its second three tries."""

    request: Request
    mode: Mode | None
    tries: int = 0
    sent_at: float = -math.inf
    was_away: bool = False
    again: bool = False
    own: Mode | None = None


def begin_asking(request: Request | None, before: Asking | None, status: KnownStatus) -> Asking | None:
    """What a phase asks for that has just begun. HOLD that was asked for goes on being the same asking."""
    if request is None:
        return None
    if before is not None and before.request is request:
        return before
    climbs = before is not None and before.request is Request.TAKE_OFF and before.tries
    return Asking(request, status.mode, own=Mode.TAKEOFF if climbs else None)


def update_asking(
    asking: Asking, answer: Answer | None, status: KnownStatus, phase: Phase, now: float, *, lost: bool
) -> tuple[Asking, bool]:
    """The asking after this moment, and whether it is sent now. ``lost``: the phase began because no state comes."""
    if answer is not None and answer.accepted:
        return asking, False
    if status.mode_age > BACK_AFTER:
        return (asking if asking.was_away else asking._replace(was_away=True)), False
    if not _allowed(asking, status):
        return asking, False
    if asking.was_away and asking.request is Request.HOLD and asking.tries and not asking.again:
        asking = asking._replace(tries=0, again=True)
    oldest = FRESH_LOST if lost and not asking.tries else FRESH
    if asking.tries >= TRIES or status.mode_age > oldest:
        return asking, False
    if now - asking.sent_at < (RETRY_HOLD if phase is Phase.ABORT else RETRY) - 1e-9:
        return asking, False
    return asking._replace(tries=asking.tries + 1, sent_at=now, was_away=False), True


def next_at(asking: Asking | None, phase: Phase) -> float:
    """s, when ``update_asking`` may have something to send again; inf for never."""
    if asking is None or asking.tries >= TRIES:
        return math.inf
    return asking.sent_at + (RETRY_HOLD if phase is Phase.ABORT else RETRY)


def _allowed(asking: Asking, status: KnownStatus) -> bool:
    """Whether what is known of the vehicle lets this be asked of it."""
    request = asking.request
    if request is Request.HOLD:  # only to end OFFBOARD, which PX4 keeps in mind through failsafes and landings
        return status.intended is Mode.OFFBOARD or (status.intended is None and status.mode is Mode.OFFBOARD)
    if status.mode is None or status.mode not in (asking.mode, asking.own):
        return False
    if request is Request.ARM:
        return status.armed is False and status.landed is Landed.ON_GROUND and not status.was_armed
    if request in (Request.TAKE_OFF, Request.DISARM):
        return status.armed is True and status.landed is Landed.ON_GROUND
    return status.armed is True
