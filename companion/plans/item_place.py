"""Where an item says to fly, or why that is no place."""

from __future__ import annotations

import math

from companion.plans.items import AMSL_FRAMES, RELATIVE_FRAMES, TERRAIN_FRAMES, Item, Place


def place_of(item: Item) -> Place | str:
    """The place of an item (latitude, longitude, altitude are its last three parameters), or what is wrong with it."""
    latitude, longitude, altitude = item.params[4:7]
    if 180.0 < abs(longitude) <= 360.0:
        longitude = math.remainder(longitude, 360.0)  # across the 180th meridian
    if item.frame in TERRAIN_FRAMES:
        return "its altitude is over the terrain, which is not known here; expected one above home or sea"
    if item.frame not in AMSL_FRAMES and item.frame not in RELATIVE_FRAMES:
        return f"its place is in frame {item.frame}; expected latitude and longitude (0, 3, 5 or 6)"
    if not (math.isfinite(latitude) and math.isfinite(longitude) and abs(latitude) <= 89.0 and abs(longitude) <= 180.0):
        return f"no place on the earth: latitude {latitude:g}, longitude {longitude:g}"
    if latitude == longitude == 0.0:
        return "latitude 0, longitude 0, which stands for no place at all; expected where to fly"
    if not math.isfinite(altitude):
        return "no altitude; where it was to be over the terrain, the ground station had no data"
    if not -500.0 <= altitude <= 10_000.0:
        return f"an altitude of {altitude:g} m; expected -500 to 10000"
    return Place(latitude, longitude, altitude, item.frame in AMSL_FRAMES)
