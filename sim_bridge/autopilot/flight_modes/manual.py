"""What the modes that need a pilot fly: position, altitude, stabilized and acro, from the deflections of the sticks."""

from __future__ import annotations

import math

from companion.frames import Quaternion, euler_from_rotation, multiply, rotation_matrix
from companion.mavlink.modes import Mode
from sim_bridge.autopilot.flight_modes.guidance import CLOSED_OF_HOVER, Throttle, takeoff_throttle
from sim_bridge.autopilot.flight_modes.manual_control import ManualControlSetpoint
from sim_bridge.autopilot.flight_modes.setpoints import AttitudeSetpoint, RatesSetpoint
from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.control.position import Target
from sim_bridge.control.reference import Reference, TrajectoryLimits, along
from sim_bridge.sensors import Estimate

BY_POSITION = frozenset({Mode.POSITION, Mode.POSITION_SLOW})
BY_PLACE_OR_HEIGHT = BY_POSITION | {Mode.ALTITUDE, Mode.ALTITUDE_CRUISE}
"""Modes that fly through the position loop."""
STANDS_STILL = 0.05
"""m/s below which a reference that is brought to rest has come to rest."""
SOFTNESS = 0.6
"""How much of a deflection is cubed: PX4's expo."""
TAKES_OFF = 0.3
"""Deflection of the throttle above which a vehicle on the ground takes off."""


class ManualFlight:
    """The manual modes of one vehicle. ``hover``: the normalised thrust that carries it; ``gravity``: m/s^2."""

    def __init__(self, parameters: Parameters, hover: float, gravity: float) -> None:
        self._parameters = parameters
        self._hover = hover
        self._gravity = gravity
        self._mode = Mode.POSITION
        self._heading = 0.0
        self._reference = Reference((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        self._rises_from: float | None = None  # s armed, when the throttle began to open
        self.target: Target | None = None

    def enter(self, mode: Mode, now: Estimate) -> None:
        """Begin a mode from where the vehicle is and as fast as it moves."""
        self._mode = mode
        self._heading = _heading_of(now)
        self._reference = Reference(now.p_n, now.v_n)

    def aim(
        self, now: Estimate, sticks: ManualControlSetpoint, height: float, armed_for: float, landed: bool, stands: bool,
        touching: bool, step: float,
    ) -> Target | Throttle:  # fmt: skip
        """Of position and altitude: what the position loop is to fly for the next ``step`` s.

        ``height``: m above home; ``armed_for``: s; ``stands``: the legs are on the ground.
        """
        climb = self._shaped(sticks.throttle)
        rises = self._rises_from is not None and stands and climb > 0.0
        if landed or rises:
            self.enter(self._mode, now)
            self.target = None
            wants = rises or (sticks.throttle > TAKES_OFF and armed_for >= self._parameters["COM_SPOOLUP_TIME"])
            if not wants:
                self._rises_from = None
                return Throttle(0.0)
            self._rises_from = armed_for if self._rises_from is None else self._rises_from
            return takeoff_throttle(
                armed_for - self._rises_from, self._parameters["MPC_Z_VEL_MAX_UP"], self._parameters
            )  # fmt: skip
        self._rises_from = None
        if touching and climb < 0.0:
            return Throttle(CLOSED_OF_HOVER)
        rate = self._turned(sticks, step)
        level = (self._shaped(sticks.pitch), self._shaped(sticks.roll))
        north, east = self._ahead(*level)
        self.target = self._place(now, north, east, self._vertical(climb, height), rate, step)
        return self.target

    def setpoint(
        self, now: Estimate, sticks: ManualControlSetpoint, landed: bool, step: float
    ) -> AttitudeSetpoint | RatesSetpoint:
        """Of stabilized, manual and acro: what the inner loops are to fly for the next ``step`` s."""
        limits = self._parameters
        if self._mode is Mode.ACRO:
            roll, pitch, yaw = (math.radians(limits[f"MC_ACRO_{axis}_MAX"]) for axis in "RPY")
            rates = (sticks.roll * roll, -sticks.pitch * pitch, sticks.yaw * yaw)
            return RatesSetpoint(rates, 0.5 * (sticks.throttle + 1.0))
        if landed:
            self._heading = _heading_of(now)
        rate = self._turned(sticks, step)
        most = math.radians(limits["MPC_MAN_TILT_MAX"])
        about_x, about_y = sticks.roll * most, -sticks.pitch * most
        tilt = math.hypot(about_x, about_y)
        if tilt > most:
            about_x, about_y, tilt = about_x * most / tilt, about_y * most / tilt, most
        turn: Quaternion = (math.cos(0.5 * self._heading), 0.0, 0.0, math.sin(0.5 * self._heading))
        sine_over_angle = 0.5 if tilt == 0.0 else math.sin(0.5 * tilt) / tilt
        return AttitudeSetpoint(
            multiply(turn, (math.cos(0.5 * tilt), about_x * sine_over_angle, about_y * sine_over_angle, 0.0)),
            self._throttle(sticks.throttle), rate,
        )  # fmt: skip

    def _vertical(self, climb: float, height: float) -> float:
        """The velocity (m/s down) a throttle asks for ``height`` m above home: slow near the ground."""
        limits = self._parameters
        low, high = limits["MPC_LAND_ALT2"], limits["MPC_LAND_ALT1"]
        share = max(0.0, min(1.0, (height - low) / max(1e-3, high - low)))
        if climb > 0.0:
            most, slow = limits["MPC_Z_VEL_MAX_UP"], limits["MPC_TKO_SPEED"]
        else:
            most, slow = limits["MPC_Z_VEL_MAX_DN"], limits["MPC_LAND_SPEED"]
        allowed = slow + share * (most - slow)
        return max(-allowed, min(allowed, -climb * most))

    def _place(self, now: Estimate, north: float, east: float, down: float, rate: float, step: float) -> Target:
        limits = self._parameters
        level_is_flown = self._mode in BY_POSITION
        most = max(0.1, min(limits["MPC_VEL_MANUAL"], limits["MPC_XY_VEL_MAX"]))
        velocity = (north * most, east * most, down) if level_is_flown else (0.0, 0.0, down)
        hardest = limits["MPC_ACC_HOR_MAX"]
        if (north, east) != (0.0, 0.0):  # as against a drag that holds the speed at last: PX4's acceleration mode
            vx, vy, _ = self._reference.v_n
            gap = math.hypot(velocity[0] - vx, velocity[1] - vy)
            hardest = min(hardest, max(0.05, 2.0 * limits["MPC_ACC_HOR"] / most * gap))
        level = TrajectoryLimits(acceleration=hardest, jerk=limits["MPC_JERK_MAX"])
        (x, y, _), (vx, vy, _), (ax, ay, _) = along(self._reference, velocity, level, step)
        upright = level._replace(acceleration=limits["MPC_ACC_UP_MAX" if down < 0.0 else "MPC_ACC_DOWN_MAX"])
        (_, _, z), (_, _, vz), (_, _, az) = along(self._reference, velocity, upright, step)
        rests = (north, east) == (0.0, 0.0) and math.hypot(vx, vy) < STANDS_STILL
        rests_in_height = down == 0.0 and abs(vz) < STANDS_STILL
        if not rests:
            x, y = now.p_n[:2]
        if not rests_in_height:
            z = now.p_n[2]
        self._reference = Reference((x, y, z), (vx, vy, vz), (ax, ay, az))
        height = z if rests_in_height else None
        if not level_is_flown:
            most = self._gravity * math.tan(math.radians(limits["MPC_MAN_TILT_MAX"]))
            return Target((None, None, height), (None, None, vz), self._heading, (north * most, east * most, az), rate)
        place = (x, y, height) if rests else (None, None, height)
        return Target(place, (vx, vy, vz), self._heading, (ax, ay, az), rate)

    def _turned(self, sticks: ManualControlSetpoint, step: float) -> float:
        """The rate (rad/s) the heading is turned at by the yaw stick; the heading goes with it."""
        rate = self._shaped(sticks.yaw) * math.radians(self._parameters["MPC_MAN_Y_MAX"])
        self._heading = math.remainder(self._heading + rate * step, math.tau)
        return rate

    def _ahead(self, forward: float, right: float) -> tuple[float, float]:
        """A level deflection, at most 1 long, as (north, east)."""
        length = math.hypot(forward, right)
        if length > 1.0:
            forward, right = forward / length, right / length
        c, s = math.cos(self._heading), math.sin(self._heading)
        return (c * forward - s * right, s * forward + c * right)

    def _shaped(self, deflection: float) -> float:
        """A deflection with its dead zone taken out and its middle softened."""
        dead = self._parameters["MAN_DEADZONE"]
        beyond = math.copysign(max(0.0, abs(deflection) - dead) / max(1e-3, 1.0 - dead), deflection)
        return (1.0 - SOFTNESS) * beyond + SOFTNESS * beyond**3

    def _throttle(self, deflection: float) -> float:
        """Normalised thrust: the middle of the stick hovers."""
        least, most = self._parameters["MPC_MANTHR_MIN"], self._parameters["MPC_THR_MAX"]
        if deflection < 0.0:
            return least + (deflection + 1.0) * (self._hover - least)
        return self._hover + deflection * (most - self._hover)


def _heading_of(now: Estimate) -> float:
    return euler_from_rotation(rotation_matrix(now.q_nb))[0]
