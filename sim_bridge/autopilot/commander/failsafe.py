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
    FALLBACK_POSCTRL = 2
    FALLBACK_ALTCTRL = 3
    FALLBACK_STAB = 4
    HOLD = 5
    RTL = 6
    LAND = 7
    DESCEND = 8
    DISARM = 9
    TERMINATE = 10


class ClearCondition(enum.Enum):
    """How long an action stays."""

    WHEN_CONDITION_CLEARS = enum.auto()
    ON_MODE_CHANGE_OR_DISARM = enum.auto()
    ON_DISARM = enum.auto()
    NEVER = enum.auto()


class UserTakeoverAllowed(enum.IntEnum):
    """Who may take over from an action. The later ones are stricter; DELAYED becomes one of the first two."""

    ALWAYS = 0
    ALWAYS_MODE_SWITCH_ONLY = 1
    AUTO = 2
    NEVER = 3


class ActionOptions(NamedTuple):
    """What a cause asks for."""

    action: Action
    clear_condition: ClearCondition = ClearCondition.WHEN_CONDITION_CLEARS
    allow_user_takeover: UserTakeoverAllowed = UserTakeoverAllowed.AUTO


MODE_FROM_ACTION = {
    Action.FALLBACK_POSCTRL: Mode.POSITION,
    Action.FALLBACK_ALTCTRL: Mode.ALTITUDE,
    Action.FALLBACK_STAB: Mode.STABILIZED,
    Action.HOLD: Mode.HOLD,
    Action.RTL: Mode.RETURN,
    Action.LAND: Mode.LAND,
    Action.DESCEND: Mode.DESCEND,
    Action.TERMINATE: Mode.TERMINATION,
}
"""The mode an action flies; the others leave the mode alone."""
_AT_ONCE = {Action.NONE, Action.WARN, Action.HOLD, Action.DISARM, Action.TERMINATE}
"""Actions that are never preceded by a hold."""
_CAN_BE_TAKEN_OVER = {Action.HOLD, Action.RTL, Action.LAND, Action.DESCEND}
_UNDER_WAY: dict[Mode, tuple[Action, ...]] = {
    Mode.LAND: (Action.RTL,),
    Mode.RETURN: (Action.RTL,),
    Mode.PRECISION_LAND: (Action.RTL, Action.LAND),
}
"""What a mode that leads to the ground already does well enough."""
_MODE_SWITCH_ONLY = UserTakeoverAllowed.ALWAYS_MODE_SWITCH_ONLY
_SHORTEST_DELAY = 0.1
"""s: COM_FAIL_ACT_T below which there is no hold before the action."""


@dataclass(slots=True)
class _Active:
    option: ActionOptions
    failing: bool = True


class Situation(NamedTuple):
    """What an update is told. ``causes``: what is wrong; ``mode_fallback``: what a mode that cannot run asks for."""

    t: float
    armed: bool
    user_intended_mode: Mode
    user_intended_mode_updated: bool
    rc_sticks_takeover_request: bool
    causes: Mapping[str, ActionOptions]
    can_run: Callable[[Mode], bool]
    mode_fallback: Callable[[Mode], Action]
    delay: float


class Verdict(NamedTuple):
    """What comes of it: the mode the operator is taken to mean now, and a text for the operator."""

    user_intended_mode: Mode
    text: str | None


class Failsafe:
    """``action``: what is done now; ``user_takeover_active``: whether somebody has taken over from an action."""

    def __init__(self) -> None:
        self.action = Action.NONE
        self.user_takeover_active = False
        self._active: dict[str, _Active] = {}
        self._armed = False
        self._user_intended_mode: Mode | None = None
        self._t: float | None = None
        self._current_delay = 0.0  # s until a delayed action
        self._current_start_delay: float | None = None

    @property
    def is_acting(self) -> bool:
        """Whether more than a warning is done."""
        return self.action > Action.WARN

    def update(self, now: Situation) -> Verdict:
        """One look at what is wrong."""
        passed = 0.0 if self._t is None else now.t - self._t
        self._t = now.t
        if self._current_start_delay is None:
            self._current_start_delay = now.delay
        requested = now.user_intended_mode_updated or (
            self._user_intended_mode is not None and self._user_intended_mode is not now.user_intended_mode
        )
        if now.armed is not self._armed:
            self._release(ClearCondition.ON_DISARM)
            self._release(ClearCondition.ON_MODE_CHANGE_OR_DISARM)
            self.user_takeover_active = False
        if requested or self.user_takeover_active:
            self._release(ClearCondition.ON_MODE_CHANGE_OR_DISARM)
        self._current_delay = max(0.0, self._current_delay - passed)
        self._look_at(now)
        if self.action > Action.HOLD or not now.can_run(Mode.HOLD) or self.user_takeover_active:
            self._current_delay = 0.0
        action, delayed, user_intended_mode, user_takeover_active = self._selected_action(now, requested)
        if delayed is not Action.NONE:
            self._current_start_delay = max(0.0, self._current_start_delay - passed)
        else:
            self._current_start_delay = min(now.delay, self._current_start_delay + passed / 4.0)
        text = None
        if action > self.action and action is not Action.WARN:
            holds = action is Action.HOLD and delayed is not Action.NONE
            seconds = int(self._current_delay + 0.5)
            text = f"Failsafe activated: entering Hold for {seconds} seconds\t" if holds else "Failsafe activated\t"
        if not self.is_acting and action > Action.WARN and user_intended_mode is Mode.ORBIT:
            user_intended_mode = Mode.HOLD
        self.action, self.user_takeover_active = action, user_takeover_active
        self._armed, self._user_intended_mode = now.armed, user_intended_mode
        return Verdict(user_intended_mode, text)

    def _release(self, clear_condition: ClearCondition) -> None:
        """Let go of what has passed and waited for this."""
        for name in [
            n for n, a in self._active.items() if not a.failing and a.option.clear_condition is clear_condition
        ]:
            del self._active[name]

    def _look_at(self, now: Situation) -> None:
        for name, option in now.causes.items():
            active = self._active.get(name)
            if active is not None:
                active.failing = True
                active.option = active.option._replace(action=option.action)
                continue
            if option.allow_user_takeover is UserTakeoverAllowed.AUTO:
                if now.delay > _SHORTEST_DELAY:
                    if option.action is not Action.WARN and self._current_delay == 0.0:
                        self._current_delay = self._current_start_delay or 0.0
                    option = option._replace(allow_user_takeover=UserTakeoverAllowed.ALWAYS)
                else:
                    option = option._replace(allow_user_takeover=UserTakeoverAllowed.ALWAYS_MODE_SWITCH_ONLY)
            self._active[name] = _Active(option)
            if option.action >= Action.HOLD:
                self.user_takeover_active = False
        for name in [n for n in self._active if n not in now.causes]:
            if self._active[name].option.clear_condition is ClearCondition.WHEN_CONDITION_CLEARS:
                del self._active[name]
            else:
                self._active[name].failing = False

    def _selected_action(self, now: Situation, requested: bool) -> tuple[Action, Action, Mode, bool]:
        """The action, the one behind a hold, the intent, and whether somebody has taken over."""
        user_intended_mode = now.user_intended_mode
        if user_intended_mode is Mode.TERMINATION or self.action is Action.TERMINATE:  # which never ends
            return Action.TERMINATE, Action.NONE, user_intended_mode, False
        if not (now.armed and self._active):
            return Action.NONE, Action.NONE, user_intended_mode, False
        acting = [a.option for a in self._active.values() if a.option.action is not Action.NONE]
        action = max((option.action for option in acting), default=Action.NONE)
        takeover = max((option.allow_user_takeover for option in acting), default=UserTakeoverAllowed.ALWAYS)
        delayed = Action.NONE
        if (
            self._current_delay > 0.0
            and not self.user_takeover_active
            and takeover <= _MODE_SWITCH_ONLY
            and action not in _AT_ONCE
        ):  # fmt: skip
            action, delayed, takeover = Action.HOLD, action, _MODE_SWITCH_ONLY
        by_mode = requested and self.is_acting
        wanted = (
            self.user_takeover_active
            or by_mode
            or (now.rc_sticks_takeover_request and takeover is UserTakeoverAllowed.ALWAYS)
        )
        taken_over = action in _CAN_BE_TAKEN_OVER and takeover <= _MODE_SWITCH_ONLY and wanted
        if taken_over:
            if now.rc_sticks_takeover_request and not self.user_takeover_active:
                user_intended_mode = Mode.POSITION
            action, delayed = Action.WARN, Action.NONE
            action = max(action, now.mode_fallback(user_intended_mode))
        action = _possible(action, now.can_run)
        under_way = _UNDER_WAY.get(user_intended_mode, ())
        if (action in under_way or delayed in under_way) and now.can_run(user_intended_mode):
            action, delayed = Action.WARN, Action.NONE
        return action, delayed, user_intended_mode, taken_over


def _possible(action: Action, can_run: Callable[[Mode], bool]) -> Action:
    """The action, or the next worse one whose mode can run."""
    while action in MODE_FROM_ACTION and action is not Action.TERMINATE and not can_run(MODE_FROM_ACTION[action]):
        action = Action(action + 1) if action is not Action.DESCEND else Action.TERMINATE
    return action
