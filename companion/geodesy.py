"""PX4's own map projection: azimuthal equidistant, on a sphere.

PX4's local frame is defined by this and not by WGS-84; against the ellipsoid it stretches east-west ranges by up to
0.3 % at 47 degrees north. Degrees outside, metres and radians inside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from companion.frames import Vec3

EARTH_RADIUS = 6371000.0
"""m, PX4's CONSTANTS_RADIUS_OF_EARTH."""


class Home(NamedTuple):
    """Where a vehicle starts from and returns to: degrees, and m above mean sea level, None where that is not known."""

    latitude: float
    longitude: float
    altitude: float | None


class GivenHome(NamedTuple):
    """What is told of home beside the mission's file, or in its stead: by the user, by a simulated world. None: as the
    file says. Degrees, m above mean sea level."""

    latitude: float | None = None
    longitude: float | None = None
    altitude: float | None = None

    def over(self, planned: Home | None) -> Home | None:
        """Home as it is told, and where it is not, as it was ``planned``; None where nobody says."""
        if self.latitude is not None and self.longitude is not None:
            return Home(self.latitude, self.longitude, self.altitude)
        return planned if planned is None or self.altitude is None else planned._replace(altitude=self.altitude)


NO_HOME_GIVEN = GivenHome()


@dataclass(frozen=True, slots=True)
class MapProjection:
    """The plane that touches the sphere at (``latitude``, ``longitude``), degrees.

    Distances and bearings from that point are true; everything else is nearly so for as far as a quadrotor flies.
    """

    latitude: float
    longitude: float
    _sin: float = field(init=False, repr=False, compare=False)
    _cos: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_sin", math.sin(math.radians(self.latitude)))
        object.__setattr__(self, "_cos", math.cos(math.radians(self.latitude)))

    def project(self, latitude: float, longitude: float) -> tuple[float, float]:
        """(north, east) in m of a point given in degrees."""
        turn = math.radians(longitude - self.longitude)
        sin_lat, cos_lat = math.sin(math.radians(latitude)), math.cos(math.radians(latitude))
        cos_turn = math.cos(turn)
        c = math.acos(max(-1.0, min(1.0, self._sin * sin_lat + self._cos * cos_lat * cos_turn)))
        k = EARTH_RADIUS * (c / math.sin(c) if c > 0.0 else 1.0)
        return (k * (self._cos * sin_lat - self._sin * cos_lat * cos_turn), k * cos_lat * math.sin(turn))

    def reproject(self, north: float, east: float) -> tuple[float, float]:
        """(latitude, longitude) in degrees of a point given in m; the longitude within +-180."""
        x, y = north / EARTH_RADIUS, east / EARTH_RADIUS
        c = math.hypot(x, y)
        if c == 0.0:
            return (self.latitude, self.longitude)
        sin_c, cos_c = math.sin(c), math.cos(c)
        latitude = math.asin(max(-1.0, min(1.0, cos_c * self._sin + x * sin_c * self._cos / c)))
        turn = math.atan2(y * sin_c, c * self._cos * cos_c - x * self._sin * sin_c)
        return (math.degrees(latitude), math.remainder(self.longitude + math.degrees(turn), 360.0))


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """Where a vehicle's local NED frame stands on the earth: ``latitude`` and ``longitude`` in degrees, ``altitude`` in
    m above mean sea level of its origin. PX4 puts it where its estimator started (GPS_GLOBAL_ORIGIN), which is neither
    where the vehicle stands nor where its home is.
    """

    latitude: float
    longitude: float
    altitude: float
    _map: MapProjection = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_map", MapProjection(self.latitude, self.longitude))

    def to_local(self, latitude: float, longitude: float, altitude: float) -> Vec3:
        """North, east, down in m of a place given in degrees and m above mean sea level."""
        north, east = self._map.project(latitude, longitude)
        return (north, east, self.altitude - altitude)

    def to_global(self, p_n: Vec3) -> tuple[float, float, float]:
        """Latitude and longitude in degrees and altitude in m above mean sea level of a point of the frame."""
        return (*self._map.reproject(p_n[0], p_n[1]), self.altitude - p_n[2])

    def north_at(self, latitude: float, longitude: float) -> float:
        """rad clockwise from the frame's x axis: where true north points at a place. Zero on the frame's own meridian;
        a tenth of a degree 10 km east of it, at 47 degrees north."""
        north, east = self._map.project(latitude - 1e-4, longitude)
        further_north, further_east = self._map.project(latitude + 1e-4, longitude)
        return math.atan2(further_east - east, further_north - north)
