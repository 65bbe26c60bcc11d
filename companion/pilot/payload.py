"""What the payload is to do where the path comes to it: each command once a pass, as soon as its place is reached."""

from __future__ import annotations

import math
from bisect import bisect_right

from companion.flight.phases import Phase
from companion.mission import PathAction
from companion.pilot.memory import Memory, PayloadProgress
from companion.pilot.targets import remaining
from companion.plan import Plan

AT_THE_END = 0.1
"""m from the end point within which a path that is rested at has been flown. Engineering choice."""


def due(plan: Plan, memory: Memory) -> tuple[Memory, tuple[PathAction, ...]]:
    """The memory after this tick, and the commands whose places were passed in it. What was flown counts from the
    leg's beginning and never back: a vehicle that is pushed back does not do a thing twice."""
    actions, progress = plan.mission.actions, memory.path.progress
    if not actions or progress is None or memory.phase not in (Phase.FOLLOW, Phase.REST):
        return memory, ()
    length, forward = plan.table.length, plan.direction * memory.path.leg > 0.0
    along = progress.s if forward else length - progress.s
    payload = memory.payload
    start = payload.start
    if start is None:
        start = along - progress.travelled if plan.table.closed else 0.0
        payload = PayloadProgress(start, along - 1e-6 if plan.table.closed else -1.0, payload.sent)
    flown = start + progress.travelled if plan.table.closed else along
    if memory.phase is Phase.REST and remaining(plan, memory) < AT_THE_END:
        flown = length
    if flown <= payload.reach:
        return (memory if payload is memory.payload else memory._replace(payload=payload)), ()
    passed = _between(plan, forward, payload.reach, flown)
    return memory._replace(payload=payload._replace(reach=flown, sent=payload.sent + len(passed))), passed


def _between(plan: Plan, forward: bool, low: float, high: float) -> tuple[PathAction, ...]:
    """What lies in (low, high] of what is flown, m, lap after lap on a path that goes round."""
    actions, length = plan.mission.actions, plan.table.length
    ordered = actions if forward else actions[::-1]
    places = [action.s if forward else length - action.s for action in ordered]
    found: list[PathAction] = []
    laps = range(math.floor(low / length), math.floor(high / length) + 1) if plan.table.closed else range(1)
    for lap in laps:
        begin, end = bisect_right(places, low - lap * length), bisect_right(places, high - lap * length)
        found += ordered[begin:end]
    return tuple(found)
