"""What to do when something is wrong: PX4's failsafe state machine. No clock and no I/O: facts in, an action out.

Every cause asks for an action; the worst that is still valid counts. An action with a warning time holds first. A cause
that has passed lets go of its action at once, or when the mode changes, or when the vehicle is disarmed, or never.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from companion.mavlink.modes import Mode


class Action(enum.IntEnum):
    """What a failsafe does. The later ones win."""

    NONE = 0
    WARN = 1
    TO_POSITION = 2
    TO_ALTITUDE = 3
    TO_STABILIZED = 4
    HOLD = 5
    RETURN = 6
    LAND = 7
    DESCEND = 8
    DISARM = 9
    TERMINATE = 10


class Until(enum.Enum):
    """How long an action stays."""

    CAUSE_PASSES = enum.auto()
    MODE_CHANGES = enum.auto()
    DISARMED = enum.auto()
    FOR_EVER = enum.auto()


class Takeover(enum.IntEnum):
    """Who may take over from an action. The later ones are stricter; DELAYED becomes one of the first two."""

    ALWAYS = 0
    BY_MODE = 1
    DELAYED = 2
    NEVER = 3


class Option(NamedTuple):
    """What a cause asks for."""

    action: Action
    until: Until = Until.CAUSE_PASSES
    takeover: Takeover = Takeover.DELAYED


FLOWN = {
    Action.TO_POSITION: Mode.POSITION,
    Action.TO_ALTITUDE: Mode.ALTITUDE,
    Action.TO_STABILIZED: Mode.STABILIZED,
    Action.HOLD: Mode.HOLD,
    Action.RETURN: Mode.RETURN,
    Action.LAND: Mode.LAND,
    Action.DESCEND: Mode.DESCEND,
    Action.TERMINATE: Mode.TERMINATION,
}
"""The mode an action flies; the others leave the mode alone."""
_AT_ONCE = {Action.NONE, Action.WARN, Action.HOLD, Action.DISARM, Action.TERMINATE}
"""Actions that are never preceded by a hold."""
_CAN_BE_TAKEN_OVER = {Action.HOLD, Action.RETURN, Action.LAND, Action.DESCEND}
_UNDER_WAY: dict[Mode, tuple[Action, ...]] = {
    Mode.LAND: (Action.RETURN,),
    Mode.RETURN: (Action.RETURN,),
    Mode.PRECISION_LAND: (Action.RETURN, Action.LAND),
}
"""What a mode that leads to the ground already does well enough."""
_SHORTEST_DELAY = 0.1
"""s: COM_FAIL_ACT_T below which there is no hold before the action."""


@dataclass(slots=True)
class _Active:
    option: Option
    failing: bool = True


class Situation(NamedTuple):
    """What an update is told. ``causes``: what is wrong now; ``fallback``: what a mode that cannot run asks for."""

    t: float
    armed: bool
    intent: Mode
    mode_requested: bool
    sticks_moved: bool
    causes: Mapping[str, Option]
    can_run: Callable[[Mode], bool]
    fallback: Callable[[Mode], Action]
    delay: float


class Verdict(NamedTuple):
    """What comes of it: the mode the operator is taken to mean now, and a text for the operator."""

    intent: Mode
    text: str | None


class Failsafe:
    """``action``: what is done now; ``taken_over``: whether somebody has taken over from an action."""

    def __init__(self) -> None:
        self.action = Action.NONE
        self.taken_over = False
        self._active: dict[str, _Active] = {}
        self._armed = False
        self._intent: Mode | None = None
        self._t: float | None = None
        self._hold_left = 0.0  # s until a delayed action
        self._next_hold: float | None = None

    @property
    def is_acting(self) -> bool:
        """Whether more than a warning is done."""
        return self.action > Action.WARN

    def update(self, now: Situation) -> Verdict:
        """One look at what is wrong."""
        passed = 0.0 if self._t is None else now.t - self._t
        self._t = now.t
        if self._next_hold is None:
            self._next_hold = now.delay
        requested = now.mode_requested or (self._intent is not None and self._intent is not now.intent)
        if now.armed is not self._armed:
            self._release(Until.DISARMED)
            self._release(Until.MODE_CHANGES)
            self.taken_over = False
        if requested or self.taken_over:
            self._release(Until.MODE_CHANGES)
        self._hold_left = max(0.0, self._hold_left - passed)
        self._look_at(now)
        if self.action > Action.HOLD or not now.can_run(Mode.HOLD) or self.taken_over:
            self._hold_left = 0.0
        action, delayed, intent, taken_over = self._selected(now, requested)
        if delayed is not Action.NONE:
            self._next_hold = max(0.0, self._next_hold - passed)
        else:
            self._next_hold = min(now.delay, self._next_hold + passed / 4.0)
        text = None
        if action > self.action and action is not Action.WARN:
            holds = action is Action.HOLD and delayed is not Action.NONE
            seconds = int(self._hold_left + 0.5)
            text = f"Failsafe activated: entering Hold for {seconds} seconds\t" if holds else "Failsafe activated\t"
        if not self.is_acting and action > Action.WARN and intent is Mode.ORBIT:
            intent = Mode.HOLD
        self.action, self.taken_over = action, taken_over
        self._armed, self._intent = now.armed, intent
        return Verdict(intent, text)

    def _release(self, until: Until) -> None:
        """Let go of what has passed and waited for this."""
        for name in [n for n, a in self._active.items() if not a.failing and a.option.until is until]:
            del self._active[name]

    def _look_at(self, now: Situation) -> None:
        for name, option in now.causes.items():
            active = self._active.get(name)
            if active is not None:
                active.failing = True
                active.option = active.option._replace(action=option.action)
                continue
            if option.takeover is Takeover.DELAYED:
                if now.delay > _SHORTEST_DELAY:
                    if option.action is not Action.WARN and self._hold_left == 0.0:
                        self._hold_left = self._next_hold or 0.0
                    option = option._replace(takeover=Takeover.ALWAYS)
                else:
                    option = option._replace(takeover=Takeover.BY_MODE)
            self._active[name] = _Active(option)
            if option.action >= Action.HOLD:
                self.taken_over = False
        for name in [n for n in self._active if n not in now.causes]:
            if self._active[name].option.until is Until.CAUSE_PASSES:
                del self._active[name]
            else:
                self._active[name].failing = False

    def _selected(self, now: Situation, requested: bool) -> tuple[Action, Action, Mode, bool]:
        """The action, the one behind a hold, the intent, and whether somebody has taken over."""
        intent = now.intent
        if intent is Mode.TERMINATION or self.action is Action.TERMINATE:  # which never ends
            return Action.TERMINATE, Action.NONE, intent, False
        if not now.armed:
            return Action.NONE, Action.NONE, intent, False
        acting = [a.option for a in self._active.values() if a.option.action is not Action.NONE]
        action = max((option.action for option in acting), default=Action.NONE)
        takeover = max((option.takeover for option in acting), default=Takeover.ALWAYS)
        delayed = Action.NONE
        if (
            self._hold_left > 0.0
            and not self.taken_over
            and takeover <= Takeover.BY_MODE
            and action not in _AT_ONCE
        ):  # fmt: skip
            action, delayed, takeover = Action.HOLD, action, Takeover.BY_MODE
        by_mode = requested and self.is_acting
        wanted = self.taken_over or by_mode or (now.sticks_moved and takeover is Takeover.ALWAYS)
        taken_over = action in _CAN_BE_TAKEN_OVER and takeover <= Takeover.BY_MODE and wanted
        if taken_over:
            if now.sticks_moved and not self.taken_over:
                intent = Mode.POSITION
            action, delayed = Action.WARN, Action.NONE
            action = max(action, now.fallback(intent))
        action = _possible(action, now.can_run)
        under_way = _UNDER_WAY.get(intent, ())
        if (action in under_way or delayed in under_way) and now.can_run(intent):
            action, delayed = Action.WARN, Action.NONE
        return action, delayed, intent, taken_over


def _possible(action: Action, can_run: Callable[[Mode], bool]) -> Action:
    """The action, or the next worse one whose mode can run."""
    while action in FLOWN and action is not Action.TERMINATE and not can_run(FLOWN[action]):
        action = Action(action + 1) if action is not Action.DESCEND else Action.TERMINATE
    return action
