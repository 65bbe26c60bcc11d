"""What a world's events do: to the machine, to the estimate, to what the vehicle says, to its links; and who acts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from companion.frames import Vec3
from companion.world.events import (
    ClockJump,
    EstimatorReset,
    Event,
    Hold,
    LastingEvent,
    LinkEvent,
    LinkRecut,
    MotorFailure,
    Operator,
    PayloadDrop,
    PortChange,
    Push,
    StateFault,
    Sticks,
    Stranger,
    Wind,
)
from sim_bridge.event_schedule import EventSchedule, Marks
from sim_bridge.link_model import LinkWay
from sim_bridge.noise import Draw
from sim_bridge.plant import STILL, Plant
from sim_bridge.rotors import Four
from sim_bridge.sensors import Sensors
from sim_bridge.state_faults import StateFaults
from sim_bridge.strangers import Speaker

COMPANION = 0
"""Index of the companion's endpoint."""
GROUND_STATION = 1
"""Index of the ground station's."""
XRCE = -1
"""Index of the line to the companion's XRCE agent, which shares the companion's fate."""


@dataclass(frozen=True, slots=True)
class Reach:
    """What events act on. ``down``, ``up``: the two ways of the links; ``ask``: the operator asks the vehicle for
    something; ``dial``: the vehicle's port to the companion changes. ``draw``: chance, of what is said wrongly."""

    plant: Plant
    sensors: Sensors
    down: LinkWay
    up: LinkWay
    ask: Callable[[Operator], None]
    dial: Callable[[], None]
    draw: Draw


class WorldEvents:
    """The events of one flight at work.

    ``any``: whether there are any. ``faults``: what the vehicle says wrongly now; ``sticks``: where the pilot holds
    them, None where nobody does; ``speakers``: the strangers who speak now.
    """

    def __init__(self, events: Iterable[Event], reach: Reach) -> None:
        self._schedule = EventSchedule(events)
        self._reach = reach
        self._marks = Marks()
        self._last: list[LastingEvent] = []
        self.faults = StateFaults(reach.draw)
        self.sticks: Sticks | None = None
        self.speakers: list[Speaker] = []
        self.any = bool(self._schedule)

    def add(self, event: Event) -> None:
        """One more event, in the midst of a flight. Its times count as those of a world's."""
        self._schedule.add(event)
        self.any = True

    def update(self, t: float, now_us: int, *, armed: bool, offboard_flown: bool) -> None:
        """Let happen what is due at plant time ``t`` (s), at ``now_us`` of the bridge's clock."""
        if armed and self._marks.armed is None:
            self._marks = self._marks._replace(armed=t)
        if offboard_flown and self._marks.offboard is None:
            self._marks = self._marks._replace(offboard=t)
        for event in self._schedule.take_due(t, self._marks):
            if isinstance(event, PayloadDrop):
                self._reach.plant.drop(event.mass)
            elif isinstance(event, EstimatorReset):
                self._reach.sensors.reset(event)
            elif isinstance(event, ClockJump):
                self._reach.sensors.jump(event.by)
            elif isinstance(event, Operator):
                self._reach.ask(event)
            elif isinstance(event, PortChange):
                self._reach.dial()
        lasting = self._schedule.now(t, self._marks)
        if lasting != self._last:
            self._last = lasting
            self._change(lasting, now_us)

    def _change(self, lasting: list[LastingEvent], now_us: int) -> None:
        """Other events last than a step ago."""
        plant = self._reach.plant
        winds = [event.wind_n for event in lasting if isinstance(event, Wind)]
        plant.wind_n = winds[-1] if winds else plant.world.wind_n
        pushes = [event.force_n for event in lasting if isinstance(event, Push)]
        plant.push_n = _sum(pushes) if pushes else STILL
        plant.is_held = any(isinstance(event, Hold) for event in lasting)
        failures = [event for event in lasting if isinstance(event, MotorFailure)]
        plant.left = _left(failures) if failures else None
        self.faults.use(event for event in lasting if isinstance(event, StateFault))
        on_link = [event for event in lasting if isinstance(event, LinkEvent)]
        self._reach.down.set_events([(event, _endpoints(event)) for event in on_link if event.down], now_us)
        self._reach.up.set_events([(event, _endpoints(event)) for event in on_link if event.up], now_us)
        self.sticks = next((event for event in lasting if isinstance(event, Sticks)), None)
        speaking = {speaker.who: speaker for speaker in self.speakers}
        self.speakers = [speaking.get(event) or Speaker(event) for event in lasting if isinstance(event, Stranger)]


def _sum(vectors: list[Vec3]) -> Vec3:
    x, y, z = (math.fsum(axis) for axis in zip(*vectors, strict=True))
    return (x, y, z)


def _left(failures: list[MotorFailure]) -> Four:
    left = [1.0, 1.0, 1.0, 1.0]
    for failure in failures:
        for motor in (1, 2, 3, 4) if failure.motor is None else (failure.motor,):
            left[motor - 1] *= failure.left
    a, b, c, d = left
    return (a, b, c, d)


def _endpoints(event: LinkEvent) -> list[int]:
    companions = [COMPANION] if isinstance(event, LinkRecut) else [COMPANION, XRCE]  # XRCE has no stream to cut anew
    return [*(companions if event.companion else []), *([GROUND_STATION] if event.ground_station else [])]
