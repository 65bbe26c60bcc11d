"""What can go wrong in flight and what the parameters ask for then: PX4's table of failsafes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from companion.mavlink.modes import Mode
from sim_bridge.autopilot.commander.battery import ChargeState
from sim_bridge.autopilot.commander.failsafe import Action, Option, Takeover, Until
from sim_bridge.autopilot.parameters import Parameters

TERMINATION_IS_LOCKED = 121212
"""CBRK_FLIGHTTERM: with this value a vehicle that has tipped over is only warned of."""
EARLY = 3.0
"""s after spooling up within which a vehicle that tips over is disarmed."""
NO_STICKS = 4
"""COM_RC_IN_MODE: manual control is not used at all."""

_TERMINATE = Option(Action.TERMINATE, Until.FOR_EVER, Takeover.NEVER)
_LINK_LOST = {
    1: Option(Action.HOLD, Until.MODE_CHANGES),
    2: Option(Action.RETURN, Until.MODE_CHANGES),
    3: Option(Action.LAND, Until.MODE_CHANGES),
    5: _TERMINATE,
    6: Option(Action.DISARM, takeover=Takeover.NEVER),
}
"""NAV_RCL_ACT and NAV_DLL_ACT."""
_OUTSIDE = {
    0: Option(Action.NONE),
    2: Option(Action.HOLD, Until.MODE_CHANGES, Takeover.BY_MODE),
    3: Option(Action.RETURN, Until.MODE_CHANGES),
    4: _TERMINATE,
    5: Option(Action.LAND, Until.MODE_CHANGES),
}
"""GF_ACTION; anything else warns."""
_CRITICAL = {1: Action.RETURN, 2: Action.LAND, 3: Action.RETURN, 4: Action.RETURN}
_EMERGENCY = {1: Action.RETURN, 2: Action.LAND, 3: Action.LAND, 4: Action.TERMINATE}
"""COM_LOW_BAT_ACT at the two lower thresholds; anything else warns."""
OFFBOARD_LOST = {
    0: (Action.TO_POSITION, Mode.POSITION),
    1: (Action.TO_ALTITUDE, Mode.ALTITUDE),
    2: (Action.TO_STABILIZED, Mode.STABILIZED),
    3: (Action.RETURN, Mode.RETURN),
    4: (Action.LAND, Mode.LAND),
    5: (Action.HOLD, Mode.HOLD),
    6: (Action.TERMINATE, Mode.TERMINATION),
    7: (Action.DISARM, Mode.HOLD),
}
"""COM_OBL_RC_ACT."""
_EXCEPTION = {Mode.MISSION: 1, Mode.OFFBOARD: 4, Mode.ALTITUDE_CRUISE: 16} | dict.fromkeys(
    (
        Mode.HOLD, Mode.TAKEOFF, Mode.LAND, Mode.RETURN, Mode.DESCEND, Mode.FOLLOW, Mode.PRECISION_LAND, Mode.ORBIT,
        Mode.GUIDED_COURSE,
    ),
    2,
)  # fmt: skip
"""The bit of COM_RCL_EXCEPT and COM_DLL_EXCEPT that forgives a lost link in a mode."""


@dataclass(slots=True)
class Facts:
    """What is known about the vehicle and its links; whoever knows it keeps it up to date."""

    sticks_lost: bool = True
    ground_station_lost: bool = True
    offboard_lost: bool = True
    mission_missing: bool = True
    mission_failed: bool = False
    mission_finished: bool = False
    outside: bool = False
    tipped_over: bool = False
    charge: ChargeState = ChargeState.OK


@dataclass(slots=True)
class AtArming:
    """What was already so when the vehicle was armed, and is therefore not held against it."""

    since: float | None = None
    sticks_lost: bool = True
    charge: ChargeState = ChargeState.OK

    def update(self, t: float, armed: bool, facts: Facts) -> None:
        """Remember the moment of arming (s)."""
        if not armed:
            self.since, self.sticks_lost = None, facts.sticks_lost
        elif self.since is None:
            self.since, self.sticks_lost, self.charge = t, facts.sticks_lost, facts.charge
        if not facts.sticks_lost:
            self.sticks_lost = False


def causes(t: float, intent: Mode, facts: Facts, at_arming: AtArming, parameters: Parameters) -> dict[str, Option]:
    """What is wrong with an armed vehicle at ``t`` (s), and what each of it asks for."""
    found: dict[str, Option] = {}
    forgiving = _EXCEPTION.get(intent, 0)

    def number(name: str) -> int:
        return int(parameters[name])

    sticks_matter = number("COM_RC_IN_MODE") != NO_STICKS and not forgiving & number("COM_RCL_EXCEPT")
    if facts.sticks_lost and sticks_matter and not at_arming.sticks_lost:
        found["sticks"] = _LINK_LOST.get(number("NAV_RCL_ACT"), Option(Action.NONE))
    forgiven = forgiving & number("COM_DLL_EXCEPT") or intent in (Mode.LAND, Mode.PRECISION_LAND)
    if facts.ground_station_lost and number("NAV_DLL_ACT") and not forgiven:
        found["ground station"] = _LINK_LOST.get(number("NAV_DLL_ACT"), Option(Action.NONE))
    if intent is Mode.MISSION:
        if facts.mission_failed:
            found["mission"] = Option(Action.RETURN)
        if not sticks_matter and not number("NAV_DLL_ACT") and facts.mission_finished and facts.ground_station_lost:
            found["mission alone"] = Option(Action.RETURN)
    if facts.outside:
        found["outside"] = _OUTSIDE.get(number("GF_ACTION"), Option(Action.WARN))
    act = number("COM_LOW_BAT_ACT") if facts.charge > at_arming.charge else 0
    if facts.charge is ChargeState.LOW:
        found["battery low"] = Option(Action.WARN)
    elif facts.charge is ChargeState.CRITICAL:
        found["battery critical"] = Option(_CRITICAL.get(act, Action.WARN))
    elif facts.charge is ChargeState.EMERGENCY:
        found["battery emergency"] = Option(_EMERGENCY.get(act, Action.WARN))
    if facts.tipped_over:
        found["tipped over"] = _tipped_over(t, at_arming, parameters)
    return found


def fallback(intent: Mode, facts: Facts, parameters: Parameters, can_run: Callable[[Mode], bool]) -> Action:
    """What a mode that cannot run (any more) asks for. ``can_run``: whether it can, by mode, sticks apart."""
    action = Action.NONE
    if intent is Mode.OFFBOARD and facts.offboard_lost:
        action, intent = OFFBOARD_LOST.get(int(parameters["COM_OBL_RC_ACT"]), OFFBOARD_LOST[0])
        if action is Action.DISARM:
            return action
    if intent in (Mode.POSITION, Mode.POSITION_SLOW) and not can_run(intent):
        action, intent = Action.TO_ALTITUDE, Mode.ALTITUDE
    if intent is Mode.ALTITUDE and not can_run(intent):
        action, intent = Action.TO_STABILIZED, Mode.STABILIZED
    if facts.sticks_lost and action in (Action.TO_POSITION, Action.TO_ALTITUDE, Action.TO_STABILIZED):
        action = _LINK_LOST.get(int(parameters["NAV_RCL_ACT"]), Option(Action.NONE)).action
    if not can_run(intent):
        action = Action.RETURN
    return action


def _tipped_over(t: float, at_arming: AtArming, parameters: Parameters) -> Option:
    if at_arming.since is not None and t < at_arming.since + parameters["COM_SPOOLUP_TIME"] + EARLY:
        return Option(Action.DISARM)
    if int(parameters["CBRK_FLIGHTTERM"]) == TERMINATION_IS_LOCKED:
        return Option(Action.WARN)
    return Option(Action.TERMINATE)
