"""What is to be flown, as ordered before the vehicle is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from companion.estimation.learned import Learned
from companion.flight.conduct import Conduct
from companion.mission import Mission, Origin
from companion.record.ticks import TickRecorder
from companion.vehicle import OutputLevel, Vehicle
from companion.xrce.commands import Commands
from companion.xrce.flight_mode import MODE_LEVELS, FlightMode


@dataclass(frozen=True)
class Orders:
    """What is to be flown. ``objection`` looks at the mission in its real place over the ground (m, down in the local
    frame) and says why it may not be flown there.
    """

    mission: Mission
    vehicle: Vehicle
    level: OutputLevel
    duration: float | None  # s of following; None: as the mission says
    origin: Origin  # what the mission counts from where its file does not say
    auto: bool = False  # attitude may be flown in the place of rates
    set_parameters: bool = False  # the vehicle's parameters may be set for the flight
    over_xrce: bool = False  # setpoints go to PX4's XRCE client
    has_xrce: bool = False  # they might, if that were asked for
    mode_levels: frozenset[OutputLevel] = MODE_LEVELS  # what may be flown in a flight mode of ours
    conduct: Conduct = field(default_factory=Conduct)  # how; what the vehicle says of itself is added to its limits
    draw: bool = False  # the curve is uploaded as mission items, for the ground station's map
    learned: Learned | None = None  # what the vehicle's last flight left
    objection: Callable[[Mission, float], str | None] | None = None  # None: none is looked for


def commands_of(orders: Orders, recorder: TickRecorder | None) -> Commands:
    """What the setpoints of a flight over XRCE go through; the traffic is told to ``recorder``."""
    name = orders.conduct.own_mode
    mode = None if name is None else FlightMode(name, orders.level)
    return Commands(orders.level, tap=None if recorder is None else recorder.add_datagram, flight_mode=mode)
