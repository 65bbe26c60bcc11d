"""What a phase waits for while nothing else is to be done, in words for the person at the field."""

from __future__ import annotations

from companion.flight.interruptions import SILENT_AFTER, STATUS_LOST_AFTER, mode_words
from companion.flight.phases import PHASES, Phase
from companion.flight.situation import Situation


def waited_for(s: Situation) -> str | None:
    """What a flight waits for; None: nothing that need be told."""
    if s.phase is Phase.PREFLIGHT:
        return s.missing
    if s.phase not in SILENT_AFTER and s.phase is not Phase.STAND_BY:
        return None
    if s.status.mode_age > STATUS_LOST_AFTER:
        longest = SILENT_AFTER.get(s.phase)
        until = "" if longest is None else f", and the flight ends after {longest:g} s of that"
        return f"nothing is heard from the vehicle in {s.phase.value}; it goes on by itself as it was told{until}"
    if s.phase is Phase.RELEASE and s.status.armed:
        return (
            f"the vehicle flies in {mode_words(s)} by itself and is left alone; it is watched until it will not return "
            f"to OFFBOARD, for {PHASES[s.phase].time_out:g} s at most"
        )
    return None
