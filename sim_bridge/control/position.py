"""Position and velocity -> attitude and thrust: PX4's cascade of a proportional and a PID controller.

World frame NED throughout. An axis of a Target may lack a position, a velocity or both, as in an offboard setpoint.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Quaternion, Vec3, quaternion_from_euler
from sim_bridge.control.filters import LowPass
from sim_bridge.sensors import Estimate

Axes = tuple[float | None, float | None, float | None]
NOTHING: Axes = (None, None, None)

POSITION_P: Vec3 = (0.95, 0.95, 1.0)  # 1/s, MPC_XY_P, MPC_Z_P
VELOCITY_P: Vec3 = (1.8, 1.8, 4.0)  # 1/s, MPC_XY_VEL_P_ACC, MPC_Z_VEL_P_ACC
VELOCITY_I: Vec3 = (0.4, 0.4, 2.0)
"""1/s^2: MPC_XY_VEL_I_ACC, MPC_Z_VEL_I_ACC (PX4's defaults)."""
VELOCITY_D: Vec3 = (0.2, 0.2, 0.0)
"""MPC_XY_VEL_D_ACC, MPC_Z_VEL_D_ACC (PX4's defaults)."""
ACCELERATION_CUTOFF = 5.0  # Hz, MPC_VELD_LP
SPEED_MAX = 12.0  # m/s, MPC_XY_VEL_MAX
CLIMB_MAX = 3.0  # m/s, MPC_Z_VEL_MAX_UP
SINK_MAX = 1.5  # m/s, MPC_Z_VEL_MAX_DN
TILT_MAX = math.radians(45.0)  # MPC_TILTMAX_AIR
THRUST_MIN = 0.12  # MPC_THR_MIN
THRUST_MIN_OF_HOVER = 0.25
"""For a machine so strong that PX4's least thrust would carry it: a quarter of what hovers."""
HORIZONTAL_MARGIN = 0.3  # MPC_THR_XY_MARG


class Target(NamedTuple):
    """Where to be (m), how fast (m/s) and with what acceleration (m/s^2) in NED; the heading in rad."""

    position: Axes
    velocity: Axes
    heading: float
    acceleration: Axes = NOTHING
    heading_rate: float = 0.0


class PositionLoop:
    """Runs once a ``step`` of s. ``hover``: the normalised thrust that carries the vehicle. ``gravity``: m/s^2."""

    def __init__(self, hover: float, gravity: float, step: float) -> None:
        self._hover = hover
        self._gravity = gravity
        self._step = step
        self._least = min(THRUST_MIN, THRUST_MIN_OF_HOVER * hover)
        self._integral: Vec3 = (0.0, 0.0, 0.0)
        self._measured = tuple(LowPass(ACCELERATION_CUTOFF, step) for _ in range(3))

    def reset(self, integral: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """Begin afresh, with the acceleration (m/s^2) that a steady disturbance is known to ask for."""
        self._integral = integral
        for measured in self._measured:
            measured.value = 0.0

    def update(self, now: Estimate, target: Target) -> tuple[Quaternion, float]:
        """The attitude to take and the thrust (0..1) to give."""
        velocity = self._velocity_wanted(now, target)
        error = [0.0, 0.0, 0.0]
        wanted = [0.0, 0.0, 0.0]
        for axis in range(3):
            speeding = self._measured[axis].update(now.a_n[axis])
            given = target.acceleration[axis] or 0.0
            demand = velocity[axis]
            if demand is None:
                wanted[axis] = given
                continue
            error[axis] = demand - now.v_n[axis]
            corrected = VELOCITY_P[axis] * error[axis] + self._integral[axis] - VELOCITY_D[axis] * speeding
            wanted[axis] = given + corrected
        north, east, down = self._thrust(wanted, error)
        i0, i1, i2 = self._integral
        step, g = self._step, self._gravity
        self._integral = (
            i0 + VELOCITY_I[0] * error[0] * step,
            i1 + VELOCITY_I[1] * error[1] * step,
            max(-g, min(g, i2 + VELOCITY_I[2] * error[2] * step)),
        )
        return _attitude((north, east, down), target.heading), math.sqrt(north * north + east * east + down * down)

    def _velocity_wanted(self, now: Estimate, target: Target) -> Axes:
        """The velocity that leads to the target, held to the speeds allowed, the way to the position first."""
        wanted: list[float | None] = [None, None, None]
        for axis in range(3):
            place, demand = target.position[axis], target.velocity[axis]
            if place is not None:
                wanted[axis] = POSITION_P[axis] * (place - now.p_n[axis]) + (demand or 0.0)
            elif demand is not None:
                wanted[axis] = demand
        north, east, down = wanted
        if north is not None and east is not None:
            speed = math.hypot(north, east)
            if speed > SPEED_MAX:
                north, east = north * SPEED_MAX / speed, east * SPEED_MAX / speed
        if down is not None:
            down = max(-CLIMB_MAX, min(SINK_MAX, down))
        return (north, east, down)

    def _thrust(self, wanted: list[float], error: list[float]) -> Vec3:
        """The normalised thrust vector (NED) for an acceleration; zeroes or turns back errors that saturate it."""
        g, hover = self._gravity, self._hover
        x, y, z = _within_tilt(-wanted[0], -wanted[1], g)
        collective = max(self._least, (hover - wanted[2] * hover / g) / z)
        if (collective * z <= self._least and error[2] >= 0.0) or (collective * z >= 1.0 and error[2] <= 0.0):
            error[2] = 0.0
        north, east, up = -x * collective, -y * collective, z * collective
        level = math.hypot(north, east)
        margin = min(level, HORIZONTAL_MARGIN)
        up = min(up, math.sqrt(1.0 - margin * margin))
        level_max = math.sqrt(max(0.0, 1.0 - up * up))
        if level > level_max:
            north, east = north * level_max / level, east * level_max / level
        per_thrust = g / hover
        if (
            math.hypot(wanted[0], wanted[1]) > math.hypot(north, east) * per_thrust
        ):  # saturated: let the integral unwind
            error[0] -= 2.0 / VELOCITY_P[0] * (wanted[0] - north * per_thrust)
            error[1] -= 2.0 / VELOCITY_P[1] * (wanted[1] - east * per_thrust)
        return (north, east, -up)


def _within_tilt(x: float, y: float, z: float) -> Vec3:
    """The direction (x, y, z), z > 0, at unit length and within TILT_MAX of (0, 0, 1)."""
    level = math.hypot(x, y)
    most = z * math.tan(TILT_MAX)
    if level > most:
        x, y = x * most / level, y * most / level
    unit = 1.0 / math.sqrt(x * x + y * y + z * z)
    return (x * unit, y * unit, z * unit)


def _attitude(thrust: Vec3, heading: float) -> Quaternion:
    """The attitude whose -z axis is along ``thrust`` (NED) and whose nose is over ``heading``."""
    x, y, z = thrust
    unit = 1.0 / math.sqrt(x * x + y * y + z * z)
    c, s = math.cos(heading), math.sin(heading)
    forward, right, down = -unit * (c * x + s * y), -unit * (c * y - s * x), -unit * z
    return quaternion_from_euler(heading, math.atan2(forward, down), -math.asin(max(-1.0, min(1.0, right))))
