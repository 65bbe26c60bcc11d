"""Open Drone ID: what PX4 tells a transmitter by default."""

from __future__ import annotations

import math

from companion.mavlink.dialect import message
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.messages.health import is_flying
from sim_bridge.autopilot.messages.parts import Values, altitude_of, degrees_e7, place

SERIAL_NUMBER = 1  # MAV_ODID_ID_TYPE_SERIAL_NUMBER
ROTORCRAFT = 2  # MAV_ODID_UA_TYPE_HELICOPTER_OR_MULTIROTOR
SERIAL = tuple(b"STAND-IN".ljust(20, b"\0"))
"""What the stand-in calls itself, 20 bytes."""
ON_GROUND = 1  # MAV_ODID_STATUS_GROUND
AIRBORNE = 2  # MAV_ODID_STATUS_AIRBORNE
ACCURACY = {"horizontal_accuracy": 12, "vertical_accuracy": 5, "barometer_accuracy": 0, "speed_accuracy": 3}
"""Codes of MAV_ODID_HOR_ACC and its like."""
TIME_NOT_KNOWN = 65535.0
"""s after the hour: nobody knows."""
SINCE = 1_546_300_800
"""s, 1 January 2019: where Open Drone ID counts from."""
UNKNOWN_HEIGHT = -1000.0
"""m: nobody knows."""


def basic_id(a: Autopilot) -> Values:
    """OPEN_DRONE_ID_BASIC_ID."""
    return message("OPEN_DRONE_ID_BASIC_ID").values(id_type=SERIAL_NUMBER, ua_type=ROTORCRAFT, uas_id=SERIAL)


def location(a: Autopilot) -> Values:
    """OPEN_DRONE_ID_LOCATION."""
    vn, ve, vd = a.estimate.v_n
    latitude, longitude = place(a)
    altitude = altitude_of(a)
    return message("OPEN_DRONE_ID_LOCATION").values(
        status=AIRBORNE if is_flying(a) else ON_GROUND,
        direction=round(math.degrees(math.atan2(ve, vn)) % 360.0) % 360 * 100,
        speed_horizontal=min(25425, round(math.hypot(vn, ve) * 100.0)),
        speed_vertical=max(-6200, min(6200, round(-vd * 100.0))),
        latitude=latitude, longitude=longitude,
        altitude_barometric=altitude, altitude_geodetic=float(round(altitude)),
        height=a.guidance.home_n[2] - a.estimate.p_n[2],
        timestamp=TIME_NOT_KNOWN, **ACCURACY,
    )  # fmt: skip


def system(a: Autopilot) -> Values:
    """OPEN_DRONE_ID_SYSTEM: the operator stands where home is."""
    x, y, z = a.guidance.home_n
    latitude, longitude = degrees_e7(*a.projection.reproject(x, y))
    return message("OPEN_DRONE_ID_SYSTEM").values(
        operator_latitude=latitude, operator_longitude=longitude, area_count=1, area_ceiling=UNKNOWN_HEIGHT,
        area_floor=UNKNOWN_HEIGHT, operator_altitude_geo=a.home.altitude - z,
        timestamp=max(0, (a.unix_us_at_boot + a.estimate.time_us) // 1_000_000 - SINCE),
    )  # fmt: skip
