"""A world in words: its air, and each of its events, for the terminal and the page."""

from __future__ import annotations

import math
import re

from companion.frames import Vec3
from companion.world import World
from companion.world.air import Gusts
from companion.world.events import (
    ClockJump,
    EstimatorReset,
    Event,
    Hold,
    LinkCut,
    LinkDelay,
    LinkDuplicate,
    LinkEvent,
    LinkRecut,
    LinkRepeat,
    LinkThin,
    MotorFailure,
    NotANumber,
    Operator,
    PayloadDrop,
    Push,
    Silence,
    Stranger,
    Wind,
)

COMPASS = ("north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west")
STILL_BELOW = 0.05
"""m/s; less wind is called still air (engineering choice)."""
LEVEL_SHARE = 0.5
"""A force whose level part is a smaller share than this is told as up or down (engineering choice)."""


def air_in_words(world: World) -> str:
    """The mean wind and the gusts: ``wind 5.0 m/s from the south-west, gusts of 1.0 m/s``."""
    speed = math.hypot(*world.wind_n)
    words = "still air" if speed < STILL_BELOW else _wind(world.wind_n)
    if world.gusts is None:
        return words
    if isinstance(world.gusts, Gusts):
        return f"{words}, gusts of {max(world.gusts.sigma):.2g} m/s"
    return f"{words}, turbulence as in {world.gusts.wind_at_6m:.1f} m/s of wind"


def event_kind(event: Event) -> str:
    """The kind as world files spell it: ``motor_failure``."""
    if isinstance(event, NotANumber):
        return "nan_state"
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", type(event).__name__).lower()


def event_in_words(event: Event) -> str:
    """What happens, without its time: ``held still``, ``pushed with 8.0 N to the east``."""
    match event:
        case Hold():
            return "held still"
        case Push(force_n=force):
            return f"pushed with {math.hypot(*force):.1f} N {_direction(force)}"
        case Wind(wind_n=wind):
            return _wind(wind)
        case MotorFailure(motor=motor, left=left):
            return f"{'every motor' if motor is None else f'motor {motor}'} gives {100.0 * left:.0f} % of its thrust"
        case PayloadDrop(mass=mass):
            return f"a payload of {mass:.2g} kg falls off"
        case EstimatorReset():
            return "the vehicle's estimate jumps"
        case ClockJump(by=by):
            return f"the vehicle's clock jumps by {by:g} s"
        case NotANumber(part=part, value=value) if math.isnan(value):
            return f"the vehicle sends NaN as its {part.value}"
        case NotANumber(part=part, value=value):
            return f"the vehicle sends {value:g} as its {part.value}"
        case Silence(part=part):
            return f"the vehicle sends no {part.value}"
        case Operator(order=order):
            return f"the operator asks for {order.value.replace('_', ' ')}"
        case Stranger(system=system, component=component):
            return f"a stranger speaks, system {system}, component {component}"
        case LinkCut() | LinkDuplicate() | LinkRepeat() | LinkDelay() | LinkThin() | LinkRecut():
            return _link_event(event)
        case _:
            return event_kind(event).replace("_", " ")


def _link_event(event: LinkEvent) -> str:
    """``link cut from the vehicle, HEARTBEAT``: what becomes of the datagrams, which way, which messages."""
    way = "both ways" if event.down and event.up else "from the vehicle" if event.down else "to the vehicle"
    return ", ".join([f"{event_kind(event).replace('_', ' ')} {way}", *sorted(event.messages)])


def _wind(wind_n: Vec3) -> str:
    north, east, _ = wind_n
    return f"wind {math.hypot(*wind_n):.1f} m/s from the {_compass(-north, -east)}"


def _direction(force_n: Vec3) -> str:
    north, east, down = force_n
    if math.hypot(north, east) < LEVEL_SHARE * math.hypot(*force_n):
        return "downwards" if down > 0.0 else "upwards"
    return f"to the {_compass(north, east)}"


def _compass(north: float, east: float) -> str:
    return COMPASS[round(math.degrees(math.atan2(east, north)) / 45.0) % 8]
