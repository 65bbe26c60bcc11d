"""Armed or not, which mode, what to do when something is lost. No I/O, no physics: times and facts in, decisions out.

``user_intended_mode`` is what the operator asked for, ``mode`` what is flown. They differ while a failsafe acts; the
first stays, so that offboard comes back by itself when its setpoints do, until somebody asks for another mode.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.mavlink.modes import Mode
from companion.mavlink_common import MavResult, MavSeverity
from sim_bridge.autopilot.commander.external_modes import EXTERNAL, ExternalModes
from sim_bridge.autopilot.commander.failsafe import (
    MODE_FROM_ACTION,
    Action,
    ActionOptions,
    Failsafe,
    Situation,
    UserTakeoverAllowed,
)
from sim_bridge.autopilot.commander.failsafe_checks import StateAtArming, check_mode_fallback, check_state_and_mode
from sim_bridge.autopilot.commander.failsafe_flags import FailsafeFlags
from sim_bridge.autopilot.commander.offboard_check import OffboardCheck
from sim_bridge.autopilot.parameters import Parameters

READY_AFTER = 4.4
"""s from boot until the estimator has settled and arming is possible."""
FORCE = 21196.0
"""The second parameter of an arming command that does not ask whether it is safe."""

MANUAL = {
    Mode.MANUAL, Mode.ALTITUDE, Mode.POSITION, Mode.POSITION_SLOW, Mode.ACRO, Mode.STABILIZED, Mode.ALTITUDE_CRUISE,
}  # fmt: skip
"""Modes that need somebody at the sticks."""
UNSUPPORTED_MODES = {Mode.FOLLOW, Mode.GUIDED_COURSE, Mode.READY, Mode.UNKNOWN}
"""Modes that this vehicle does not fly."""
ENDING = {Mode.LAND, Mode.RETURN, Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION, Mode.ORBIT}
"""Modes in which nobody arms, and after which, once disarmed, the mode before them is back."""
HOLD_WITHOUT_A_FAILSAFE = 7
"""NAV_RCL_ACT."""
TITLES = {Mode.RETURN: "Return", Mode.LAND: "Land", Mode.HOLD: "Hold", Mode.POSITION: "Position"}


class Text(NamedTuple):
    """A text for the operator."""

    severity: MavSeverity
    text: str


class Commander:
    """The decisions of one vehicle. Times are the vehicle's clock, s. ``failsafe_flags``: kept by others."""

    def __init__(self, parameters: Parameters, ready_at: float = READY_AFTER) -> None:
        self._parameters = parameters
        self._ready_at = ready_at
        self.failsafe_flags = FailsafeFlags()
        self.external_modes = ExternalModes(parameters)
        self.armed = False
        self.armed_at = 0.0
        self.user_intended_mode = Mode.HOLD
        self.landed = True
        self.landed_at = 0.0
        self.has_flown = False
        self.setpoint_at = -math.inf
        self._failsafe = Failsafe()
        self._at_arming = StateAtArming()
        self.throttle = 0.0
        """The pilot's throttle stick, -1..1."""
        self._sticks_were_lost = True
        self._requested = False
        self._offboard_check = OffboardCheck()
        self._after_disarming = Mode.HOLD
        self.texts: list[Text] = []

    @property
    def mode(self) -> Mode:
        """What is flown."""
        action = self._failsafe.action
        if action is Action.NONE or not (self.armed or action is Action.TERMINATE):
            return self.user_intended_mode
        return MODE_FROM_ACTION.get(action, self.user_intended_mode)

    @property
    def failsafe(self) -> Mode | None:
        """What a failsafe flies; None: none does."""
        return self.mode if self.armed and self._failsafe.is_acting else None

    def is_ready(self, t: float) -> bool:
        """Whether the estimator has settled."""
        return t >= self._ready_at

    def can_run(self, mode: Mode, t: float) -> bool:
        """Whether what a mode needs is there."""
        if mode in MANUAL and self.failsafe_flags.manual_control_signal_lost:
            return False
        if mode is Mode.OFFBOARD and t - self.setpoint_at > self._parameters["COM_OF_LOSS_T"]:
            return False
        return self._mode_requirements_met(mode, t)

    def can_arm(self, t: float) -> bool:
        """Whether arming would be accepted."""
        unreachable = self.failsafe_flags.gcs_connection_lost and self._parameters["NAV_DLL_ACT"]
        kept = self._parameters["COM_ARM_MIS_REQ"] and self.failsafe_flags.auto_mission_missing
        outside = self.failsafe_flags.geofence_breached and self._parameters["GF_ACTION"]
        return self.can_run(self.mode, t) and self.mode not in ENDING and not (unreachable or kept or outside)

    def say(self, severity: MavSeverity, text: str) -> None:
        """Queue a text for the operator."""
        self.texts.append(Text(severity, text))

    def begin_in_flight(self) -> None:
        """Start ready and armed, in the air, in HOLD."""
        self._ready_at = 0.0
        self._at_arming.since = -math.inf
        self.armed, self.landed, self.has_flown = True, False, True

    def request_mode(self, mode: Mode, t: float, aloud: bool = True) -> MavResult:
        """Somebody asks for a mode. On the ground any is taken: the refusal then comes at arming.

        ``aloud``: a refusal is told in words.
        """
        terminated = self._failsafe.action is Action.TERMINATE and mode is not Mode.TERMINATION
        if terminated or (self.armed and not self.can_run(mode, t)):
            name = TITLES.get(mode, mode.name.replace("_", " ").title())
            if aloud:
                self.say(MavSeverity.CRITICAL, f"Switching to {name} is currently not available\t")
            return MavResult.TEMPORARILY_REJECTED
        self._requested = True
        self._change_user_intended_mode(mode)
        self.update(t)
        return MavResult.ACCEPTED

    def request_arming(self, arm: bool, force: bool, t: float, by: str = "external command") -> MavResult:
        """Somebody asks to arm or disarm. ``by``: how they ask."""
        if arm == self.armed:
            return MavResult.ACCEPTED
        if arm:
            if not force and not self._arming_is_accepted(t):
                return MavResult.TEMPORARILY_REJECTED
            self.armed, self.armed_at, self.has_flown = True, t, not self.landed
            self.failsafe_flags.offboard_control_signal_lost = self.mode is Mode.OFFBOARD and not self.can_run(
                Mode.OFFBOARD, t
            )
            self.say(MavSeverity.INFO, f"Armed by {by}\t")
            return MavResult.ACCEPTED
        if not self.landed and not force:
            self.say(MavSeverity.CRITICAL, "Disarming denied: not landed\t")
            return MavResult.TEMPORARILY_REJECTED
        self._disarm("external command")
        return MavResult.ACCEPTED

    def notice_sticks(self, t: float) -> None:
        """The pilot moves the sticks with intent: he takes over from whatever flies by itself."""
        if not self.armed or self.mode in MANUAL or self.mode in (Mode.ORBIT, Mode.TERMINATION):
            return
        if self._failsafe.is_acting:
            self._update_failsafe(t, rc_sticks_takeover_request=True)
        elif self.can_run(Mode.POSITION, t):
            self.say(MavSeverity.INFO, "Pilot took over using sticks\t")
            self.request_mode(Mode.POSITION, t)

    def finish_takeoff(self) -> None:
        """A take-off has reached its height."""
        if self.user_intended_mode is Mode.TAKEOFF:
            self._change_user_intended_mode(Mode.HOLD)

    def finish_mode(self, mode: Mode | None) -> None:
        """The last item of the mission has been flown, in the air; or whoever brought a mode has taken it away."""
        if self.user_intended_mode is mode:
            self._change_user_intended_mode(Mode.HOLD)

    def notice_setpoint(self, t: float) -> None:
        """An offboard setpoint of any kind."""
        self.setpoint_at = t

    def notice_landing(self, landed: bool, t: float) -> None:
        """The landing detector's word."""
        if landed == self.landed:
            return
        self.landed = landed
        if landed:
            self.landed_at = t
            self.say(MavSeverity.INFO, "Landing detected\t")
        else:
            self.has_flown = True
            self.say(MavSeverity.INFO, "Takeoff detected\t")

    def update(self, t: float) -> None:
        """Look at the clock and at the facts: what is lost or back, automatic disarming."""
        self._watch_setpoints(t)
        self._watch_sticks()
        self.external_modes.update(t, self.armed, self.user_intended_mode)
        self._update_failsafe(t)
        if self.armed and self.landed:
            at_the_end = self.user_intended_mode is Mode.MISSION and self.failsafe_flags.mission_finished
            wait = 0.0 if at_the_end else self._parameters["COM_DISARM_LAND"]
            if self.has_flown and t - self.landed_at >= wait and self._parameters["COM_DISARM_LAND"] > 0.0:
                self._disarm("landing")
            elif not self.has_flown and t - self.armed_at >= self._parameters["COM_DISARM_PRFLT"] > 0.0:
                self._disarm("auto preflight disarming")

    def _update_failsafe(self, t: float, rc_sticks_takeover_request: bool = False) -> None:
        """Let the failsafe decide."""
        flags, parameters = self.failsafe_flags, self._parameters
        self._at_arming.update(t, self.armed, flags)

        def can_run(mode: Mode) -> bool:
            return self._mode_requirements_met(mode, t) and not (
                mode is Mode.OFFBOARD and flags.offboard_control_signal_lost
            )

        wrong = (
            {}
            if not self.armed
            else check_state_and_mode(t, self.user_intended_mode, flags, self._at_arming, parameters)
        )
        falls_to = check_mode_fallback(self.user_intended_mode, flags, parameters, can_run)
        if self.armed and falls_to is not Action.NONE:
            wrong["mode_fallback"] = ActionOptions(falls_to, allow_user_takeover=UserTakeoverAllowed.ALWAYS)
        requested, self._requested = self._requested, False
        verdict = self._failsafe.update(Situation(
            t, self.armed, self.user_intended_mode, requested, rc_sticks_takeover_request, wrong, can_run,
            lambda mode: check_mode_fallback(mode, flags, parameters, can_run), parameters["COM_FAIL_ACT_T"],
        ))  # fmt: skip
        if verdict.user_intended_mode is not self.user_intended_mode:
            self._change_user_intended_mode(verdict.user_intended_mode)
        if verdict.text is not None:
            self.say(MavSeverity.CRITICAL, verdict.text)
        if self._failsafe.action is Action.DISARM:
            self._disarm("failsafe")

    def _watch_setpoints(self, t: float) -> None:
        """Notice that offboard setpoints stay away, or are back."""
        self.failsafe_flags.offboard_control_signal_lost = self._offboard_check.is_lost(
            t, self.setpoint_at, self._parameters["COM_OF_LOSS_T"],
            was_lost=self.failsafe_flags.offboard_control_signal_lost,
            is_flown=self.armed and self.user_intended_mode is Mode.OFFBOARD,
        )  # fmt: skip

    def _watch_sticks(self) -> None:
        """With one setting the loss of the sticks is no failsafe: the vehicle changes to hold, as if told to."""
        before, lost = self._sticks_were_lost, self.failsafe_flags.manual_control_signal_lost
        self._sticks_were_lost = lost
        just_lost = lost and not before and self.armed and self.mode in MANUAL
        if just_lost and int(self._parameters["NAV_RCL_ACT"]) == HOLD_WITHOUT_A_FAILSAFE:
            self.say(MavSeverity.INFO, "Manual control lost: switching to Hold\t")
            self._requested = True
            self._change_user_intended_mode(Mode.HOLD)

    def _mode_requirements_met(self, mode: Mode, t: float) -> bool:
        """Whether a mode can run, sticks and setpoints apart."""
        if mode in UNSUPPORTED_MODES or not self.is_ready(t):
            return False
        if mode in EXTERNAL:
            return self.external_modes.can_run(mode)
        return mode is not Mode.MISSION or not self.failsafe_flags.auto_mission_missing

    def _arming_is_accepted(self, t: float) -> bool:
        """Whether arming is accepted; if not, why not is said."""
        if self.mode in MANUAL and not self.failsafe_flags.manual_control_signal_lost:
            climbs = self.mode in (Mode.POSITION, Mode.POSITION_SLOW, Mode.ALTITUDE, Mode.ALTITUDE_CRUISE)
            if self.throttle > 0.2 if climbs else self.throttle >= -0.8:
                self.say(MavSeverity.CRITICAL, "Arming denied: throttle not in safe position\t")
                return False
        if not self.can_arm(t):
            self.say(MavSeverity.CRITICAL, "Arming denied: Resolve system health failures first\t")
            return False
        return True

    def _change_user_intended_mode(self, mode: Mode) -> None:
        if mode is Mode.OFFBOARD and self.user_intended_mode is not Mode.OFFBOARD:
            self.failsafe_flags.offboard_control_signal_lost = False  # looked at when it was asked for
        self.user_intended_mode = mode
        if mode not in ENDING and mode is not Mode.TAKEOFF:
            self._after_disarming = mode

    def _disarm(self, why: str) -> None:
        self.armed = False
        self.user_intended_mode = self._after_disarming
        self.say(MavSeverity.INFO, f"Disarmed by {why}\t")
