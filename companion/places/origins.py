"""Where a mission stands in the local frame of the vehicle that is to fly it.

PX4's local frame begins where its estimator started. A mission counts from there (``local``), from where the vehicle
stands (``takeoff``), from where it would return to (``home``), or from a place on the earth. Only with what the vehicle
says of itself do these become points of its local frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.frames import Vec3
from companion.geodesy import LocalFrame
from companion.mission import GlobalOrigin, Mission, Origin
from companion.vehicle import CompanionError

FAR = 50_000.0
"""m; a mission farther away is not meant for this vehicle."""
HOME_AGREES = 5.0
"""m within which the two ways a vehicle tells its home must agree."""


class PlaceError(CompanionError):
    """A mission that cannot be placed: the vehicle does not say enough of where it is, or is somewhere else."""


class NotKnownError(PlaceError):
    """The vehicle has not said enough of where it is; it may yet, once its GPS knows."""


@dataclass(frozen=True, slots=True)
class VehicleLocation:
    """What a vehicle says of where it is; None where it has not said.

    ``p_n``: its position in its local frame, m. ``on_ground``: whether it stands. ``frame``: where its local frame
    stands (GPS_GLOBAL_ORIGIN). ``home``: latitude, longitude in degrees and altitude in m above mean sea level of where
    it would return to, ``home_n``: the same in its local frame (both HOME_POSITION).
    """

    p_n: Vec3
    on_ground: bool | None = None
    frame: LocalFrame | None = None
    home: tuple[float, float, float] | None = None
    home_n: Vec3 | None = None


def placed(mission: Mission, default: Origin, where: VehicleLocation) -> Mission:
    """The mission in the local frame of a vehicle. ``default``: what it counts from where its file does not say.
    PlaceError: that is not known, in words for the pilot."""
    origin = mission.origin or default
    origin_n = origin_in(origin, where)
    turn = mission.placement.turn
    if isinstance(origin, GlobalOrigin):
        assert where.frame is not None  # or there is no origin_n
        turn += where.frame.north_at(origin.latitude, origin.longitude)
    return mission.placed(origin_n, turn)


def origin_in(origin: Origin | GlobalOrigin, where: VehicleLocation) -> Vec3:
    """The origin of a mission in the local frame of a vehicle, m. PlaceError: it is not known."""
    if isinstance(origin, GlobalOrigin):
        origin_n = _on_earth(origin, where)
    elif origin is Origin.LOCAL:
        return (0.0, 0.0, 0.0)
    elif origin is Origin.HOME:
        origin_n = home_in(where)
    else:
        if not where.on_ground:
            raise PlaceError("origin: takeoff needs a vehicle on the ground, this one flies; name another origin")
        return where.p_n
    away = math.hypot(origin_n[0] - where.p_n[0], origin_n[1] - where.p_n[1])
    if away > FAR:
        raise PlaceError(f"the mission's origin lies {away / 1000.0:.0f} km from the vehicle; it is for another place")
    return origin_n


def home_in(where: VehicleLocation) -> Vec3:
    """The vehicle's home in its local frame, m. PlaceError: it is not known."""
    if where.frame is None or where.home is None:
        if where.home_n is None:
            raise NotKnownError(
                "origin: home is not known, the vehicle has not set one (HOME_POSITION); wait for its GPS"
            )
        return where.home_n
    # the place on the earth counts: home_n may be older than the frame's present origin
    home_n = where.frame.to_local(*where.home)
    if where.home_n is not None and math.dist(where.home_n, home_n) > HOME_AGREES:
        apart = f"{math.dist(where.home_n, home_n):.0f} m apart"
        raise PlaceError(f"origin: home is given twice, {apart}; set home again, or name another origin")
    return home_n


def _on_earth(origin: GlobalOrigin, where: VehicleLocation) -> Vec3:
    if where.frame is None:
        message = "the mission counts from a place on the earth, and the vehicle has not said where its local frame is"
        raise NotKnownError(f"{message} (GPS_GLOBAL_ORIGIN); wait for its GPS, or name another origin")
    altitude = origin.altitude
    if origin.above_home:
        altitude += where.frame.altitude - home_in(where)[2]
    return where.frame.to_local(origin.latitude, origin.longitude, altitude)
