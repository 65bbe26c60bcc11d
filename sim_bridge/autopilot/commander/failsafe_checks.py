"""What can go wrong in flight and what the parameters ask for then: PX4's table of failsafes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from companion.mavlink.modes import Mode
from sim_bridge.autopilot.commander.battery import ChargeState
from sim_bridge.autopilot.commander.external_modes import EXTERNAL
from sim_bridge.autopilot.commander.failsafe import Action, ActionOptions, ClearCondition, UserTakeoverAllowed
from sim_bridge.autopilot.commander.failsafe_flags import FailsafeFlags
from sim_bridge.autopilot.parameters import Parameters

CBRK_FLIGHTTERM_ENGAGED = 121212
"""CBRK_FLIGHTTERM: with this value a vehicle that has tipped over is only warned of."""
SPOOLED_UP_RECENTLY = 3.0
"""s after spooling up within which a vehicle that tips over is disarmed."""
STICK_INPUT_DISABLED = 4
"""COM_RC_IN_MODE: manual control is not used at all."""

_TERMINATE = ActionOptions(Action.TERMINATE, ClearCondition.NEVER, UserTakeoverAllowed.NEVER)
_LINK_LOST = {
    1: ActionOptions(Action.HOLD, ClearCondition.ON_MODE_CHANGE_OR_DISARM),
    2: ActionOptions(Action.RTL, ClearCondition.ON_MODE_CHANGE_OR_DISARM),
    3: ActionOptions(Action.LAND, ClearCondition.ON_MODE_CHANGE_OR_DISARM),
    5: _TERMINATE,
    6: ActionOptions(Action.DISARM, allow_user_takeover=UserTakeoverAllowed.NEVER),
}
"""NAV_RCL_ACT and NAV_DLL_ACT."""
_GEOFENCE = {
    0: ActionOptions(Action.NONE),
    2: ActionOptions(Action.HOLD, ClearCondition.ON_MODE_CHANGE_OR_DISARM, UserTakeoverAllowed.ALWAYS_MODE_SWITCH_ONLY),
    3: ActionOptions(Action.RTL, ClearCondition.ON_MODE_CHANGE_OR_DISARM),
    4: _TERMINATE,
    5: ActionOptions(Action.LAND, ClearCondition.ON_MODE_CHANGE_OR_DISARM),
}
"""GF_ACTION; anything else warns."""
_BATTERY_CRITICAL = {1: Action.RTL, 2: Action.LAND, 3: Action.RTL, 4: Action.RTL}
"""COM_LOW_BAT_ACT at BAT_CRIT_THR; anything else warns."""
_BATTERY_EMERGENCY = {1: Action.RTL, 2: Action.LAND, 3: Action.LAND, 4: Action.TERMINATE}
"""COM_LOW_BAT_ACT at the two lower thresholds; anything else warns."""
OFFBOARD_LOST = {
    0: (Action.FALLBACK_POSCTRL, Mode.POSITION),
    1: (Action.FALLBACK_ALTCTRL, Mode.ALTITUDE),
    2: (Action.FALLBACK_STAB, Mode.STABILIZED),
    3: (Action.RTL, Mode.RETURN),
    4: (Action.LAND, Mode.LAND),
    5: (Action.HOLD, Mode.HOLD),
    6: (Action.TERMINATE, Mode.TERMINATION),
    7: (Action.DISARM, Mode.HOLD),
}
"""COM_OBL_RC_ACT."""
_EXCEPTION_BIT = {Mode.MISSION: 1, Mode.OFFBOARD: 4, Mode.ALTITUDE_CRUISE: 16} | dict.fromkeys(
    (
        Mode.HOLD, Mode.TAKEOFF, Mode.LAND, Mode.RETURN, Mode.DESCEND, Mode.FOLLOW, Mode.PRECISION_LAND, Mode.ORBIT,
        Mode.GUIDED_COURSE,
    ),
    2,
) | dict.fromkeys(EXTERNAL, 8)  # fmt: skip
"""The bit of COM_RCL_EXCEPT and COM_DLL_EXCEPT that forgives a lost link in a mode."""


@dataclass(slots=True)
class StateAtArming:
    """What was already so when the vehicle was armed, and is therefore not held against it."""

    since: float | None = None
    manual_control_signal_lost: bool = True
    battery_warning: ChargeState = ChargeState.OK

    def update(self, t: float, armed: bool, flags: FailsafeFlags) -> None:
        """Remember the moment of arming (s)."""
        if not armed:
            self.since, self.manual_control_signal_lost = None, flags.manual_control_signal_lost
        elif self.since is None:
            self.since, self.manual_control_signal_lost, self.battery_warning = (
                t,
                flags.manual_control_signal_lost,
                flags.battery_warning,
            )
        if not flags.manual_control_signal_lost:
            self.manual_control_signal_lost = False


def check_state_and_mode(
    t: float, user_intended_mode: Mode, flags: FailsafeFlags, at_arming: StateAtArming, parameters: Parameters
) -> dict[str, ActionOptions]:
    """What is wrong with an armed vehicle at ``t`` (s), and what each of it asks for."""
    found: dict[str, ActionOptions] = {}
    forgiving = _EXCEPTION_BIT.get(user_intended_mode, 0)

    def number(name: str) -> int:
        return int(parameters[name])

    sticks_matter = number("COM_RC_IN_MODE") != STICK_INPUT_DISABLED and not forgiving & number("COM_RCL_EXCEPT")
    if flags.manual_control_signal_lost and sticks_matter and not at_arming.manual_control_signal_lost:
        found["manual_control_signal_lost"] = _LINK_LOST.get(number("NAV_RCL_ACT"), ActionOptions(Action.NONE))
    forgiven = forgiving & number("COM_DLL_EXCEPT") or user_intended_mode in (Mode.LAND, Mode.PRECISION_LAND)
    if flags.gcs_connection_lost and number("NAV_DLL_ACT") and not forgiven:
        found["gcs_connection_lost"] = _LINK_LOST.get(number("NAV_DLL_ACT"), ActionOptions(Action.NONE))
    if user_intended_mode is Mode.MISSION:
        if flags.mission_failure:
            found["mission_failure"] = ActionOptions(Action.RTL)
        if not sticks_matter and not number("NAV_DLL_ACT") and flags.mission_finished and flags.gcs_connection_lost:
            found["mission_finished"] = ActionOptions(Action.RTL)
    if flags.geofence_breached:
        found["geofence_breached"] = _GEOFENCE.get(number("GF_ACTION"), ActionOptions(Action.WARN))
    act = number("COM_LOW_BAT_ACT") if flags.battery_warning > at_arming.battery_warning else 0
    if flags.battery_warning is ChargeState.LOW:
        found["battery_low"] = ActionOptions(Action.WARN)
    elif flags.battery_warning is ChargeState.CRITICAL:
        found["battery_critical"] = ActionOptions(_BATTERY_CRITICAL.get(act, Action.WARN))
    elif flags.battery_warning is ChargeState.EMERGENCY:
        found["battery_emergency"] = ActionOptions(_BATTERY_EMERGENCY.get(act, Action.WARN))
    if flags.fd_critical_failure:
        found["fd_critical_failure"] = _fd_critical_failure(t, at_arming, parameters)
    return found


def check_mode_fallback(
    user_intended_mode: Mode, flags: FailsafeFlags, parameters: Parameters, can_run: Callable[[Mode], bool]
) -> Action:
    """What a mode that cannot run (any more) asks for. ``can_run``: whether it can, by mode, sticks apart."""
    action = Action.NONE
    if user_intended_mode is Mode.OFFBOARD and flags.offboard_control_signal_lost:
        action, user_intended_mode = OFFBOARD_LOST.get(int(parameters["COM_OBL_RC_ACT"]), OFFBOARD_LOST[0])
        if action is Action.DISARM:
            return action
    if user_intended_mode in (Mode.POSITION, Mode.POSITION_SLOW) and not can_run(user_intended_mode):
        action, user_intended_mode = Action.FALLBACK_ALTCTRL, Mode.ALTITUDE
    if user_intended_mode is Mode.ALTITUDE and not can_run(user_intended_mode):
        action, user_intended_mode = Action.FALLBACK_STAB, Mode.STABILIZED
    if flags.manual_control_signal_lost and action in (
        Action.FALLBACK_POSCTRL,
        Action.FALLBACK_ALTCTRL,
        Action.FALLBACK_STAB,
    ):
        action = _LINK_LOST.get(int(parameters["NAV_RCL_ACT"]), ActionOptions(Action.NONE)).action
    if not can_run(user_intended_mode):
        action = Action.RTL
    return action


def _fd_critical_failure(t: float, at_arming: StateAtArming, parameters: Parameters) -> ActionOptions:
    if at_arming.since is not None and t < at_arming.since + parameters["COM_SPOOLUP_TIME"] + SPOOLED_UP_RECENTLY:
        return ActionOptions(Action.DISARM)
    if int(parameters["CBRK_FLIGHTTERM"]) == CBRK_FLIGHTTERM_ENGAGED:
        return ActionOptions(Action.WARN)
    return ActionOptions(Action.TERMINATE)
