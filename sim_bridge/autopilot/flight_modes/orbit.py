"""Flying round a point at a distance, for ever: DO_ORBIT."""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from companion.frames import Vec3
from sim_bridge.control.reference import Reference, TrajectoryLimits, along
from sim_bridge.sensors import Estimate

RADIUS_MIN = 1.0
"""m, of PX4's orbit."""
APPROACH = 0.5
"""1/s: how quickly a distance that is not the wanted one is made up for."""
APPROACH_MOST = 5.0
"""m/s towards the circle at most, where nothing is left for going round."""


class OrbitYawBehaviour(enum.IntEnum):
    """ORBIT_YAW_BEHAVIOUR: where the nose points."""

    HOLD_FRONT_TO_CIRCLE_CENTER = 0
    HOLD_INITIAL_HEADING = 1
    UNCONTROLLED = 2
    HOLD_FRONT_TANGENT_TO_CIRCLE = 3
    RC_CONTROLLED = 4
    UNCHANGED = 5


class Orbit(NamedTuple):
    """Round ``centre`` (m, NED; its height is flown) at ``radius`` (m), with ``speed`` (m/s), clockwise if positive.

    ``yaw_behaviour``: where it points, an ``OrbitYawBehaviour``; by hand and uncontrolled, the heading stays.
    """

    centre: Vec3
    radius: float
    speed: float
    yaw_behaviour: int = OrbitYawBehaviour.HOLD_FRONT_TO_CIRCLE_CENTER

    def moved(self, reference: Reference, limits: TrajectoryLimits, step: float) -> Reference:
        """The reference one ``step`` (s) further round."""
        north, east, down = reference.p_n
        n, e = north - self.centre[0], east - self.centre[1]
        distance = math.hypot(n, e)
        out = (n / distance, e / distance) if distance > 0.01 else (1.0, 0.0)
        inward = max(-APPROACH_MOST, min(APPROACH_MOST, APPROACH * (self.radius - distance)))
        round_ = self.speed * max(0.0, 1.0 - abs(inward) / APPROACH_MOST)
        # what it takes to stay on the circle is led, or the limited acceleration would carry it outwards
        lead = round_ / max(RADIUS_MIN, distance) * 2.0 * limits.acceleration / max(0.1, limits.jerk) * 0.5
        c, s = math.cos(lead), math.sin(lead)
        tangent = (-out[1], out[0])
        tangent = (c * tangent[0] - s * tangent[1], s * tangent[0] + c * tangent[1])
        climb = max(-limits.climb, min(limits.sink, self.centre[2] - down))
        velocity = (inward * out[0] + round_ * tangent[0], inward * out[1] + round_ * tangent[1], climb)
        return along(reference, velocity, limits, step)

    def heading(self, now: Estimate, held: float) -> float:
        """Where the nose is to point (rad). ``held``: where it points."""
        north, east = self.centre[0] - now.p_n[0], self.centre[1] - now.p_n[1]
        if self.yaw_behaviour == OrbitYawBehaviour.HOLD_FRONT_TO_CIRCLE_CENTER and math.hypot(north, east) > 0.1:
            return math.atan2(east, north)
        if self.yaw_behaviour == OrbitYawBehaviour.HOLD_FRONT_TANGENT_TO_CIRCLE:
            return math.atan2(now.v_n[1], now.v_n[0])
        return held


def orbit_from_command(
    before: Orbit | None, parameters: tuple[float, float, float], centre: Vec3 | None, now: Estimate, most: float
) -> Orbit | None:  # fmt: skip
    """The orbit a command asks for: radius (negative: counter-clockwise), speed, nose; NaN: as before, or PX4's own.

    ``centre``: None where not given. ``most``: the largest radius. None: the radius is out of bounds.
    """
    radius, speed, yaw_behaviour = parameters
    clockwise = radius > 0.0 if math.isfinite(radius) else before is None or before.speed > 0.0
    size = abs(radius) if math.isfinite(radius) else RADIUS_MIN if before is None else before.radius
    fast = speed if math.isfinite(speed) else 1.0 if before is None else abs(before.speed)
    if not RADIUS_MIN <= size <= most:
        return None
    behaviour: int = OrbitYawBehaviour.HOLD_FRONT_TO_CIRCLE_CENTER if before is None else before.yaw_behaviour
    if math.isfinite(yaw_behaviour) and round(yaw_behaviour) != OrbitYawBehaviour.UNCHANGED:
        behaviour = round(yaw_behaviour)
    where = centre or (now.p_n if before is None else before.centre)
    bound = math.sqrt(2.0 * size)  # the centripetal acceleration PX4 allows itself: 2 m/s^2
    fast = max(-bound, min(bound, fast))
    return Orbit(where, size, fast if clockwise else -fast, behaviour)
