"""The phases of a flight and the table of what follows what.

Pre-emptions are looked at first: a fault, a human or a stop ends what is being done. Everything here is data; the tests
walk it and the diagram in docs/ is printed from it.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Phase(enum.Enum):
    """What the flight is doing."""

    PREFLIGHT = "preflight"
    ARM = "arm"
    TAKE_OFF = "take off"
    STAND_BY = "stand by"
    TAKE_OVER = "take over"
    SETTLE = "settle"
    JOIN = "join"
    FOLLOW = "follow"
    REST = "rest"
    HAND_BACK = "hand back"
    LAND = "land"
    RETURN = "return"
    DISARM = "disarm"
    ABORT = "abort"
    RELEASE = "release"
    REHEARSE = "rehearse"
    DONE = "done"

    __hash__ = object.__hash__  # members are the only ones of their kind; Enum's own goes by the name, in Python


class Event(enum.Enum):
    """What may happen."""

    READY_ON_GROUND = "ready on the ground"
    READY_IN_AIR = "ready in the air"
    READY_FOR_PILOT = "ready for the pilot"
    READY_TO_REHEARSE = "ready to rehearse"
    ARMED = "armed"
    IN_AIR = "in the air"
    IN_OFFBOARD = "in offboard"
    SETTLED = "thrust known"
    JOINED = "at the path"
    AT_END = "at the end of the path"
    TURNED = "ready to fly back"
    FINISHED = "finished"
    HELD = "held in the air"
    HELD_TO_LAND = "held, to be landed"
    HELD_TO_RETURN = "held, to return"
    DOWN = "on the ground"
    DISARMED = "disarmed"
    LET_GO = "offboard no longer meant"
    # pre-empting
    NOT_OURS = "not to be begun"
    STOP_ON_GROUND = "told to stop on the ground"
    STOP = "told to stop"
    LEFT_OFFBOARD = "pilot left offboard"
    TAKEN_OVER = "mode changed by another"
    FAILSAFE = "vehicle in a failsafe"
    DISARMED_EXTERNALLY = "disarmed by another"
    STALE = "state is stale"
    STATUS_LOST = "mode is not known"
    SILENT = "vehicle is silent"
    LAW_FAILED = "law not defined"
    ABORT_REQUIRED = "a guard aborts"
    HAND_BACK_REQUIRED = "a guard hands back"
    REFUSED = "refused by the vehicle"
    TIMED_OUT = "took too long"


class Request(enum.Enum):
    """What a phase asks of the vehicle until telemetry confirms it."""

    ARM = "arm"
    DISARM = "disarm"
    TAKE_OFF = "take off"
    OFFBOARD = "offboard mode"
    HOLD = "hold mode"
    LAND = "land"
    RETURN = "return mode"


TRIES = 3
"""Number of times that a request is sent. Issue 11, rule 2."""


@dataclass(frozen=True, slots=True)
class Row:
    """A phase: what it asks for, how long it may take (s; None: as long as it wants), whether the law steers in it."""

    request: Request | None
    time_out: float | None
    steers: bool


PHASES: dict[Phase, Row] = {
    Phase.PREFLIGHT: Row(None, 60.0, False),
    Phase.ARM: Row(Request.ARM, 5.0, False),
    Phase.TAKE_OFF: Row(Request.TAKE_OFF, 40.0, False),
    Phase.STAND_BY: Row(None, None, False),
    Phase.TAKE_OVER: Row(Request.OFFBOARD, 5.0, True),
    Phase.SETTLE: Row(None, 12.0, True),
    Phase.JOIN: Row(None, 120.0, True),
    Phase.FOLLOW: Row(None, None, True),
    Phase.REST: Row(None, 20.0, True),
    Phase.HAND_BACK: Row(Request.HOLD, 5.0, True),
    Phase.LAND: Row(Request.LAND, 180.0, False),
    Phase.RETURN: Row(Request.RETURN, 300.0, False),
    Phase.DISARM: Row(Request.DISARM, 10.0, False),
    Phase.ABORT: Row(Request.HOLD, 15.0, True),
    Phase.RELEASE: Row(Request.HOLD, 300.0, False),
    Phase.REHEARSE: Row(None, 120.0, True),
    Phase.DONE: Row(None, None, False),
}
"""s, the time-out of each phase, beside what it asks for and whether the law steers. Engineering choice."""

TRANSITIONS: dict[tuple[Phase, Event], Phase] = {
    (Phase.PREFLIGHT, Event.READY_ON_GROUND): Phase.ARM,
    (Phase.PREFLIGHT, Event.READY_IN_AIR): Phase.TAKE_OVER,
    (Phase.PREFLIGHT, Event.READY_FOR_PILOT): Phase.STAND_BY,
    (Phase.PREFLIGHT, Event.READY_TO_REHEARSE): Phase.REHEARSE,
    (Phase.ARM, Event.ARMED): Phase.TAKE_OFF,
    (Phase.TAKE_OFF, Event.IN_AIR): Phase.TAKE_OVER,
    (Phase.STAND_BY, Event.IN_OFFBOARD): Phase.SETTLE,
    (Phase.TAKE_OVER, Event.IN_OFFBOARD): Phase.SETTLE,
    (Phase.SETTLE, Event.SETTLED): Phase.JOIN,
    (Phase.JOIN, Event.JOINED): Phase.FOLLOW,
    (Phase.FOLLOW, Event.FINISHED): Phase.HAND_BACK,
    (Phase.FOLLOW, Event.AT_END): Phase.REST,
    (Phase.REST, Event.TURNED): Phase.FOLLOW,
    (Phase.REST, Event.FINISHED): Phase.HAND_BACK,
    (Phase.HAND_BACK, Event.HELD): Phase.DONE,
    (Phase.HAND_BACK, Event.HELD_TO_LAND): Phase.LAND,
    (Phase.HAND_BACK, Event.HELD_TO_RETURN): Phase.RETURN,
    (Phase.LAND, Event.DOWN): Phase.DISARM,
    (Phase.RETURN, Event.DOWN): Phase.DISARM,
    (Phase.DISARM, Event.DISARMED): Phase.RELEASE,
    (Phase.ABORT, Event.HELD): Phase.DONE,
    (Phase.RELEASE, Event.LET_GO): Phase.DONE,
    (Phase.REHEARSE, Event.FINISHED): Phase.DONE,
}

FLOWN = (Phase.SETTLE, Phase.JOIN, Phase.FOLLOW, Phase.REST)
"""The phases in which the vehicle flies on our setpoints and is meant to."""
NOT_FLYING = frozenset({Phase.PREFLIGHT, Phase.STAND_BY})
"""The phases in which it does not: one that was switched on anew is taken again, gains and limits may be set."""

PRE_EMPTIONS: tuple[tuple[Event, dict[Phase, Phase]], ...] = (
    (Event.DISARMED_EXTERNALLY, dict.fromkeys(
        (Phase.ARM, Phase.TAKE_OFF, Phase.TAKE_OVER, *FLOWN, Phase.HAND_BACK, Phase.ABORT), Phase.RELEASE)),
    (Event.LEFT_OFFBOARD, dict.fromkeys(FLOWN, Phase.STAND_BY)),
    (Event.TAKEN_OVER, dict.fromkeys(
        (Phase.ARM, Phase.TAKE_OFF, Phase.TAKE_OVER, *FLOWN, Phase.LAND, Phase.RETURN), Phase.DONE)),
    (Event.FAILSAFE, dict.fromkeys(
        (Phase.TAKE_OFF, Phase.TAKE_OVER, *FLOWN, Phase.LAND, Phase.RETURN), Phase.RELEASE)),
    (Event.NOT_OURS, {Phase.PREFLIGHT: Phase.DONE}),
    (Event.SILENT, dict.fromkeys((Phase.ARM, Phase.TAKE_OFF, Phase.LAND, Phase.RETURN, Phase.RELEASE), Phase.DONE)),
    (Event.STALE, dict.fromkeys((Phase.TAKE_OVER, *FLOWN, Phase.HAND_BACK), Phase.ABORT)),
    (Event.STATUS_LOST, dict.fromkeys((Phase.TAKE_OVER, *FLOWN, Phase.HAND_BACK), Phase.ABORT)),
    (Event.LAW_FAILED, {
        **dict.fromkeys((Phase.TAKE_OVER, *FLOWN, Phase.HAND_BACK), Phase.ABORT),
        Phase.REHEARSE: Phase.DONE,
    }),
    (Event.ABORT_REQUIRED, dict.fromkeys((Phase.TAKE_OVER, *FLOWN, Phase.HAND_BACK), Phase.ABORT)),
    (Event.HAND_BACK_REQUIRED, dict.fromkeys((Phase.TAKE_OVER, *FLOWN), Phase.HAND_BACK)),
    (Event.STOP_ON_GROUND, {Phase.TAKE_OFF: Phase.DISARM}),
    (Event.STOP, {
        Phase.PREFLIGHT: Phase.DONE,
        Phase.ARM: Phase.DISARM,
        Phase.TAKE_OFF: Phase.HAND_BACK,
        Phase.STAND_BY: Phase.DONE,
        Phase.TAKE_OVER: Phase.HAND_BACK,
        **dict.fromkeys(FLOWN, Phase.HAND_BACK),
        Phase.RELEASE: Phase.DONE,
        Phase.REHEARSE: Phase.DONE,
    }),
    (Event.REFUSED, {
        Phase.ARM: Phase.DONE,
        Phase.TAKE_OFF: Phase.DISARM,
        Phase.TAKE_OVER: Phase.ABORT,
        Phase.RETURN: Phase.DONE,
    }),
    (Event.TIMED_OUT, {
        Phase.PREFLIGHT: Phase.DONE,
        Phase.ARM: Phase.DONE,
        Phase.TAKE_OFF: Phase.DISARM,
        Phase.TAKE_OVER: Phase.ABORT,
        **dict.fromkeys(FLOWN, Phase.HAND_BACK),
        Phase.HAND_BACK: Phase.ABORT,
        Phase.LAND: Phase.DONE,
        Phase.RETURN: Phase.DONE,
        Phase.DISARM: Phase.DONE,
        Phase.ABORT: Phase.DONE,
        Phase.RELEASE: Phase.DONE,
        Phase.REHEARSE: Phase.DONE,
    }),
)  # fmt: skip
"""The worst first: of several events at once, the first that knows the phase decides."""


def _rows() -> dict[Phase, tuple[tuple[Event, Phase], ...]]:
    rows: dict[Phase, list[tuple[Event, Phase]]] = {phase: [] for phase in Phase}
    for event, by_phase in PRE_EMPTIONS:
        for phase, following in by_phase.items():
            rows[phase].append((event, following))
    for (phase, event), following in TRANSITIONS.items():
        rows[phase].append((event, following))
    return {phase: tuple(found) for phase, found in rows.items()}


EXITS = _rows()
"""For each phase its events, the most urgent first, and the phase each leads to."""


def diagram() -> str:
    """The normal flight as a Mermaid state diagram, for docs/."""
    lines = ["stateDiagram-v2", "    [*] --> preflight"]

    def name(phase: Phase) -> str:
        return phase.value.replace(" ", "_")

    for (phase, event), following in TRANSITIONS.items():
        lines.append(f"    {name(phase)} --> {name(following)}: {event.value}")
    lines.append("    done --> [*]")
    return "\n".join(lines) + "\n"


def pre_emption_table() -> str:
    """What pre-empts it as a Markdown table, the most urgent first, for docs/."""
    lines = ["| what happens | in | then |", "|---|---|---|"]
    for event, rows in PRE_EMPTIONS:
        for following in dict.fromkeys(rows.values()):
            phases = ", ".join(phase.value for phase, leads_to in rows.items() if leads_to is following)
            lines.append(f"| {event.value} | {phases} | {following.value} |")
    return "\n".join(lines) + "\n"
