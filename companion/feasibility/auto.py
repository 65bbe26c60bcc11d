"""``speed: auto`` made into a speed."""

from __future__ import annotations

from dataclasses import replace

from companion.mission import Mission
from companion.profiles import AutoSpeed
from companion.vehicle import Vehicle


def flyable(mission: Mission, vehicle: Vehicle) -> Mission:
    """The mission with its speed known: ``auto`` made into a profile for ``vehicle``. Takes a second for a flight of
    a minute. TooSlowError: no speed is slow enough."""
    if not isinstance(mission.speed, AutoSpeed):
        return mission
    from companion.feasibility.fastest import Fastest  # scipy takes longer to import than all the rest of a command

    return replace(mission, speed=Fastest(mission, mission.speed, vehicle).profile())
