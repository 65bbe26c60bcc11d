"""Whether the vehicle is on the ground, as PX4 tells it: by what it feels and how far the throttle is open."""

from __future__ import annotations

import math

from sim_bridge.autopilot.parameters import Parameters
from sim_bridge.sensors import Estimate

TAKEOFF_THROTTLE = 0.30
"""Throttle over hover throttle from which a vehicle on the ground counts as taking off."""
CONTACT_TIME = 1.25
"""s of standing on something, while asked to sink, until that is taken for the ground and the throttle is closed."""
LOW_TIME = 0.7
"""s of standing with a low throttle until the vehicle counts as landed."""

STILL_TIME = 1.0 / 3.0
"""s of not moving until PX4 takes that for contact with the ground (the first of its three stages)."""
IDLE_MARGIN = 0.01
"""Normalised thrust above MPC_MANTHR_MIN that still counts as none."""


class Stillness:
    """What PX4 takes for the ground where nobody flies a climb rate: no thrust is asked for, and the vehicle stands
    still. Whoever flies it by its motors and says nothing of the thrust is believed to have landed in the air."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._since: float | None = None

    def update(self, t: float, now: Estimate, thrust: float) -> bool:
        """Whether it feels like the ground at ``t`` (s). ``thrust``: the last vehicle_thrust_setpoint, upwards."""
        limits = self._parameters
        still = (
            thrust <= limits["MPC_MANTHR_MIN"] + IDLE_MARGIN
            and abs(now.v_n[2]) < limits["LNDMC_Z_VEL_MAX"]
            and math.hypot(*now.v_n[:2]) < limits["LNDMC_XY_VEL_MAX"]
            and math.hypot(*now.w_b[:2]) < math.radians(limits["LNDMC_ROT_MAX"])
        )
        self._since = None if not still else t if self._since is None else self._since
        return self._since is not None and t - self._since >= STILL_TIME


class LandDetector:
    """``landed``: the verdict. ``touching``: the ground has been felt for long enough to close the throttle."""

    def __init__(self, landed: bool) -> None:
        self.landed = landed
        self.touching = landed
        self._contact_since: float | None = None
        self._low_since: float | None = None

    def update(self, t: float, contact: bool, throttle: float) -> bool:
        """The verdict at ``t`` (s). ``contact``: legs on the ground; ``throttle``: thrust over hover thrust."""
        low = throttle < TAKEOFF_THROTTLE
        self._contact_since = None if not contact else t if self._contact_since is None else self._contact_since
        self.touching = self._contact_since is not None and t - self._contact_since >= CONTACT_TIME
        self._low_since = None if not (contact and low) else t if self._low_since is None else self._low_since
        if self.landed:
            self.landed = contact and low
        else:
            self.landed = contact and self._low_since is not None and t - self._low_since >= LOW_TIME
        return self.landed
