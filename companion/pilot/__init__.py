"""One tick of a flight, pure: what is remembered and what is seen -> what is remembered next and what is done.

memory           what is seen, remembered and done, as values
intake           whether what arrives is a state, and how late
targets          what is aimed at in each phase, and how fast the path is flown just now
payload          what the payload is to do where the path comes to it
thrust_response  whether the vehicle makes the thrust that is commanded
thrust_change    a thrust scale that changed all at once, told
inputs           what the guards look at, gathered from memory and observation
transitions      what a moment changes of the phase
tick             the tick itself

The pilot knows no MAVLink, no clock and no files. Feeding the same observations again gives the same setpoints, bit for
bit; that is what ``companion replay`` does.
"""

from __future__ import annotations

from companion.flight.epilogue import sentence
from companion.flight.phases import FLOWN
from companion.frames import wrap
from companion.pilot.inputs import takes_commands
from companion.pilot.memory import (
    WAKE_AFTER,
    LawOutput,
    Memory,
    Observation,
    Outcome,
    Progress,
    begin,
    completed,
    may_be_selected,
    wake_at,
)
from companion.pilot.tick import DT_MAX, LEVEL_FOR, compute_setpoint, step, supervise
from companion.steering.steering import Steered
from companion.vehicle import Mode

__all__ = [
    "DT_MAX", "LEVEL_FOR", "WAKE_AFTER", "LawOutput", "Memory", "Observation", "Outcome", "Progress", "begin",
    "completed", "compute_setpoint", "epilogue", "latest_steered", "may_be_selected", "step",
    "supervise", "takes_commands", "wake_at", "yaw_error",
]  # fmt: skip


def epilogue(memory: Memory, mode: Mode | None) -> str | None:
    """What went wrong, what was done then, and what to do next, in one sentence; None where nothing did."""
    fault = memory.fault
    if fault is None or memory.last_event is None:
        return None
    return sentence(fault.reason, fault.event, fault.advice, memory.last_event, mode, memory.done)


def latest_steered(memory: Memory, outcome: Outcome) -> Steered | None:
    """How the latest setpoint came about. A tick without a new state has none of its own: the one in force."""
    kept = memory.steering.steered if memory.phase in FLOWN else None
    return outcome.steered if outcome.steered is not None else kept


def yaw_error(steered: Steered) -> float:
    """rad, psi - beta, wrapped."""
    return wrap(steered.command.yaw - steered.command.beta)
