"""How a flight is to be conducted: who arms and takes over, how it ends, what it may not leave."""

from __future__ import annotations

import enum
from typing import Any, NamedTuple

from companion.vehicle import Vehicle


class ControlAuthority(enum.Enum):
    """Who does what.

    ``COMPANION`` arms, takes off and changes the mode. ``PILOT``: the human does all that; the companion follows while
    he has OFFBOARD selected. ``REHEARSAL`` computes and sends nothing. ``BENCH`` shows, props off, that the commanded
    turning points back when the vehicle is tilted by hand.
    """

    COMPANION = "companion"
    PILOT = "pilot"
    REHEARSAL = "rehearsal"
    BENCH = "bench"


class Finish(enum.Enum):
    """What follows a path that was flown. ``AS_BEGUN``: landing where the flight began on the ground, else holding."""

    AS_BEGUN = "as begun"
    HOLD = "hold"
    LAND = "land"
    RETURN = "return"


class Limits(NamedTuple):
    """What may not be left while we fly.

    ``tube``: m of distance to the path once it was reached. ``floor``, ``ceiling``: m above ``ground`` (the down
    coordinate of the ground or of home). ``tilt``: rad. ``battery``: 0..1. ``radius``, ``height``: m from home, as the
    vehicle's own fence says. None: no limit, or not known.
    """

    tube: float | None = 5.0
    floor: float | None = None
    ceiling: float | None = None
    ground: float | None = None
    tilt: float | None = None
    battery: float | None = 0.15
    radius: float | None = None
    height: float | None = None
    home: tuple[float, float, float] | None = None


class Conduct(NamedTuple):
    """``at_once``: the path is flown from the first setpoint on, without settling or joining (a simulated flight that
    begins in a given state). ``speed_scale_max``: how much faster than the mission it may be asked to fly.
    ``own_mode``: the name of the flight mode of ours that is flown in; None: OFFBOARD."""

    authority: ControlAuthority = ControlAuthority.COMPANION
    finish: Finish = Finish.AS_BEGUN
    limits: Limits = Limits()
    at_once: bool = False
    speed_scale_max: float = 1.0
    own_mode: str | None = None


def to_dict(conduct: Conduct) -> dict[str, Any]:
    """As plain values, for the record."""
    return {
        **conduct._asdict(),
        "authority": conduct.authority.value,
        "finish": conduct.finish.value,
        "limits": conduct.limits._asdict(),
    }


def from_dict(values: dict[str, Any]) -> Conduct:
    """The conduct that ``to_dict`` made plain, by the name too that ``authority`` had before 2026-11-29 (``manner``).

    KeyError, TypeError, ValueError: it is none.
    """
    values = {"authority" if key == "manner" else key: value for key, value in values.items()}
    limits = Limits(**values["limits"])
    if limits.home is not None:
        north, east, down = limits.home
        limits = limits._replace(home=(north, east, down))
    authority, finish = ControlAuthority(values["authority"]), Finish(values["finish"])
    return Conduct(**{**values, "authority": authority, "finish": finish, "limits": limits})


def caught(conduct: Conduct, vehicle: Vehicle) -> Conduct:
    """Past PX4's rate loop nobody but us watches the tilt: it is given back while PX4 can still catch it."""
    tilt = conduct.limits.tilt
    if tilt is None or vehicle.limits is None:
        return conduct
    return conduct._replace(limits=conduct.limits._replace(tilt=min(tilt, vehicle.limits.caught_tilt)))
