"""Armed or not, which mode, what to do when something is lost. No I/O, no physics: times and facts in, decisions out.

``intent`` is what the operator asked for, ``mode`` what is flown. They differ while a failsafe acts; the intent stays,
so that offboard comes back by itself when its setpoints do, until somebody asks for another mode.
"""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from companion.mavlink.modes import Mode
from sim_bridge.autopilot.parameters import Parameters

READY_AFTER = 4.4
"""s from boot until the estimator has settled and arming is possible."""
LOSS_NOTICED_AFTER = 0.10
"""s beyond COM_OF_LOSS_T until the failsafe acts: PX4 looks ten times a second (seen: 0.05 to 0.17)."""
RETURN_NOTICED_AFTER = 0.07
"""s from the first new setpoint until offboard is resumed (seen: 0.02 to 0.13)."""
FORCE = 21196.0
"""The second parameter of an arming command that does not ask whether it is safe."""

MANUAL = {
    Mode.MANUAL, Mode.ALTITUDE, Mode.POSITION, Mode.POSITION_SLOW, Mode.ACRO, Mode.STABILIZED, Mode.ALTITUDE_CRUISE,
}  # fmt: skip
"""Modes that need somebody at the sticks."""
WITHOUT_A_PLAN = {Mode.MISSION, Mode.FOLLOW, Mode.ORBIT, Mode.PRECISION_LAND, Mode.GUIDED_COURSE, Mode.READY}
"""Modes that need something this vehicle has not been given."""
ENDING = {Mode.LAND, Mode.RETURN, Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION}
"""Modes that end on the ground: nobody arms in them, and after disarming the mode before them is back."""
OFFBOARD_LOST = {
    0: Mode.RETURN,  # Position, which needs sticks
    1: Mode.RETURN,  # Altitude, likewise
    2: Mode.RETURN,  # Stabilized, likewise
    3: Mode.RETURN,
    4: Mode.LAND,
    5: Mode.HOLD,
    6: Mode.TERMINATION,
    7: Mode.TERMINATION,
}
"""COM_OBL_RC_ACT: what follows the loss of offboard setpoints where there is no manual control."""
TITLES = {Mode.RETURN: "Return", Mode.LAND: "Land", Mode.HOLD: "Hold", Mode.POSITION: "Position"}


class Result(enum.IntEnum):
    """MAV_RESULT of a command."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5
    CANCELLED = 6
    UNSUPPORTED_FRAME = 9


class Severity(enum.IntEnum):
    """MAV_SEVERITY of a text."""

    CRITICAL = 2
    WARNING = 4
    INFO = 6


class Text(NamedTuple):
    """A text for the operator."""

    severity: Severity
    text: str


class Commander:
    """The decisions of one vehicle. Times are the vehicle's clock, s."""

    def __init__(self, parameters: Parameters, ready_at: float = READY_AFTER) -> None:
        self._parameters = parameters
        self._ready_at = ready_at
        self.armed = False
        self.armed_at = 0.0
        self.intent = Mode.HOLD
        self.failsafe: Mode | None = None
        self.landed = True
        self.landed_at = 0.0
        self.has_flown = False
        self.setpoint_at = -math.inf
        self._resumed_at: float | None = None
        self._after_disarming = Mode.HOLD
        self.texts: list[Text] = []

    @property
    def mode(self) -> Mode:
        """What is flown."""
        return self.intent if self.failsafe is None else self.failsafe

    def is_ready(self, t: float) -> bool:
        """Whether the estimator has settled."""
        return t >= self._ready_at

    def can_run(self, mode: Mode, t: float) -> bool:
        """Whether what a mode needs is there."""
        if not self.is_ready(t) or mode in MANUAL or mode in WITHOUT_A_PLAN:
            return False
        return mode is not Mode.OFFBOARD or t - self.setpoint_at <= self._parameters["COM_OF_LOSS_T"]

    def can_arm(self, t: float) -> bool:
        """Whether arming would be accepted."""
        return self.can_run(self.mode, t) and self.mode not in ENDING

    def say(self, severity: Severity, text: str) -> None:
        """Queue a text for the operator."""
        self.texts.append(Text(severity, text))

    def begin_in_flight(self) -> None:
        """Start armed, in the air, in HOLD."""
        self.armed, self.landed, self.has_flown = True, False, True

    def request_mode(self, mode: Mode, t: float, aloud: bool = True) -> Result:
        """Somebody asks for a mode. On the ground any is taken: the refusal then comes at arming.

        ``aloud``: a refusal is told in words.
        """
        if self.armed and not self.can_run(mode, t):
            name = TITLES.get(mode, mode.name.replace("_", " ").title())
            if aloud:
                self.say(Severity.CRITICAL, f"Switching to {name} is currently not available\t")
            return Result.TEMPORARILY_REJECTED
        self._intend(mode)
        return Result.ACCEPTED

    def request_arming(self, arm: bool, force: bool, t: float) -> Result:
        """Somebody asks to arm or disarm."""
        if arm == self.armed:
            return Result.ACCEPTED
        if arm:
            if not force and not self.can_arm(t):
                self.say(Severity.CRITICAL, "Arming denied: Resolve system health failures first\t")
                return Result.TEMPORARILY_REJECTED
            self.armed, self.armed_at, self.has_flown = True, t, not self.landed
            self.say(Severity.INFO, "Armed by external command\t")
            return Result.ACCEPTED
        if not self.landed and not force:
            self.say(Severity.CRITICAL, "Disarming denied: not landed\t")
            return Result.TEMPORARILY_REJECTED
        self._disarm("external command")
        return Result.ACCEPTED

    def takeoff_is_over(self) -> None:
        """A take-off has reached its height."""
        if self.intent is Mode.TAKEOFF:
            self._intend(Mode.HOLD)

    def setpoint_arrived(self, t: float) -> None:
        """An offboard setpoint of any kind."""
        self.setpoint_at = t

    def notice_landing(self, landed: bool, t: float) -> None:
        """The landing detector's word."""
        if landed == self.landed:
            return
        self.landed = landed
        if landed:
            self.landed_at = t
            self.say(Severity.INFO, "Landing detected\t")
        else:
            self.has_flown = True
            self.say(Severity.INFO, "Takeoff detected\t")

    def update(self, t: float) -> None:
        """Look at the clock: lost and resumed setpoints, automatic disarming."""
        if not self.armed:
            return
        if self.intent is Mode.OFFBOARD:
            self._watch_setpoints(t)
        if self.landed:
            if self.has_flown and t - self.landed_at >= self._parameters["COM_DISARM_LAND"]:
                self._disarm("landing")
            elif not self.has_flown and t - self.armed_at >= self._parameters["COM_DISARM_PRFLT"]:
                self._disarm("auto preflight disarming")

    def _watch_setpoints(self, t: float) -> None:
        age = t - self.setpoint_at
        limit = self._parameters["COM_OF_LOSS_T"]
        if self.failsafe is None:
            if age > limit + LOSS_NOTICED_AFTER:
                self.failsafe = OFFBOARD_LOST.get(round(self._parameters["COM_OBL_RC_ACT"]), Mode.RETURN)
                self._resumed_at = None
                self.say(Severity.CRITICAL, "Failsafe activated\t")
        elif age > limit:
            self._resumed_at = None
        elif self._resumed_at is None:
            self._resumed_at = t
        elif t - self._resumed_at >= RETURN_NOTICED_AFTER:
            self.failsafe = None

    def _intend(self, mode: Mode) -> None:
        self.intent = mode
        self.failsafe = None
        if mode not in ENDING:
            self._after_disarming = mode

    def _disarm(self, why: str) -> None:
        self.armed = False
        self.failsafe = None
        self.intent = self._after_disarming
        self.say(Severity.INFO, f"Disarmed by {why}\t")
