"""When the vehicle knows where it is, and where its home is.

Home is where a return goes. As in PX4 it is set when the estimator settles, again at arming, and follows a vehicle that
is carried away while disarmed on the ground; once somebody has set it by hand it only moves at their word.
"""

from __future__ import annotations

import math

from companion.frames import Quaternion, Vec3
from companion.geodesy import MapProjection
from companion.mavlink_common import MAV_FRAME_GLOBAL_INT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
from companion.world import Home
from sim_bridge.autopilot.flight_modes.guidance import Guidance
from sim_bridge.sensors import Estimate

ORIGIN_AFTER = 0.63
"""s from boot until the local frame has its origin. As PX4's simulation."""
HOME_AFTER = 1.9
"""s from boot until home is known. As PX4's simulation: 1.1 to 3.6."""
POSITION_AFTER = 2.7
"""s from boot until the position is good. As PX4's simulation."""
CARRIED_AWAY = 1.0
"""m from home beyond which a vehicle on the ground takes the new place for its home."""
IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)
"""An attitude: level, nose north."""


class HomePosition:
    """``origin_set_us``, ``home_set_us``: when, on the vehicle's clock; None while not yet. Home is in ``guidance``."""

    def __init__(self, guidance: Guidance, ground: Home, projection: MapProjection) -> None:
        self._guidance, self._ground, self._projection = guidance, ground, projection
        self._by_hand = False
        self._armed = False
        self.position_known = False
        self.origin_set_us: int | None = None
        self.home_set_us: int | None = None
        self.home_q: Quaternion = IDENTITY

    @property
    def p_n(self) -> Vec3 | None:
        """m, NED; None while not known."""
        return None if self.home_set_us is None else self._guidance.home_n

    @property
    def altitude(self) -> float:
        """m above the sea."""
        return self._ground.altitude - self._guidance.home_n[2]

    def place_of(self, latitude: float, longitude: float, altitude: float, frame: int) -> Vec3 | None:
        """A place on the globe (degrees, m of ``frame``) in the local frame; None: it cannot be known."""
        if not self.position_known or not math.isfinite(altitude):
            return None
        if frame == MAV_FRAME_GLOBAL_RELATIVE_ALT_INT:
            if self.home_set_us is None:
                return None
            altitude += self.altitude
        elif frame != MAV_FRAME_GLOBAL_INT:  # above the terrain, which is flat
            altitude += self._ground.altitude
        return (*self._projection.project(latitude, longitude), self._ground.altitude - altitude)

    def begin_in_flight(self) -> None:
        """Everything is known; home is the origin."""
        self.position_known = True
        self.origin_set_us = self.home_set_us = 0
        self._armed = True

    def update(self, now: Estimate, armed: bool, landed: bool) -> None:
        """Look at the clock and at what the vehicle does."""
        t = now.time_us * 1e-6
        if self.origin_set_us is None and t >= ORIGIN_AFTER:
            self.origin_set_us = now.time_us
        if not self.position_known and t >= POSITION_AFTER:
            self.position_known = True
        arms, self._armed = armed and not self._armed, armed
        if self._by_hand:
            return
        if self.home_set_us is None:
            if t >= HOME_AFTER:
                self.set_home_here(now)
        elif landed and (arms or (not armed and self._is_away(now))):
            self.set_home_here(now)

    def set_home_here(self, now: Estimate) -> None:
        """Home is where the vehicle is."""
        self._set(now.p_n, now.q_nb, now.time_us)

    def set_home(self, place: Vec3, q: Quaternion, now: Estimate) -> None:
        """Home is at ``place`` (m, NED) from now on, whatever the vehicle does."""
        self._by_hand = True
        self._set(place, q, now.time_us)

    def _set(self, place: Vec3, q: Quaternion, time_us: int) -> None:
        self._guidance.home_n = place
        self.home_q = q
        self.home_set_us = time_us

    def _is_away(self, now: Estimate) -> bool:
        home = self._guidance.home_n
        return math.hypot(now.p_n[0] - home[0], now.p_n[1] - home[1]) > CARRIED_AWAY
