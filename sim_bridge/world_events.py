"""What a world's events do: to the machine, to the estimate, to what the vehicle says, to its links."""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.frames import Vec3
from companion.mavlink.dialect import Value, message
from companion.world.events import (
    EstimatorReset,
    Event,
    Happening,
    Hold,
    LinkCut,
    MotorFailure,
    NotANumber,
    Part,
    Push,
    Silence,
    Wind,
)
from sim_bridge.event_schedule import Script
from sim_bridge.plant import STILL, Plant
from sim_bridge.rotors import Four
from sim_bridge.sensors import Sensors

Values = tuple[Value, ...]
NOBODY: frozenset[int] = frozenset()
COMPANION, GROUND_STATION = 0, 1

_POSITION, _ATTITUDE = {Part.POSITION, Part.STATE}, {Part.ATTITUDE, Part.STATE}
SAID_OF_THE_STATE: dict[int, set[Part]] = {
    message("ATTITUDE").id: _ATTITUDE,
    message("ATTITUDE_QUATERNION").id: _ATTITUDE,
    message("LOCAL_POSITION_NED").id: _POSITION,
    message("GLOBAL_POSITION_INT").id: _POSITION,
    message("ODOMETRY").id: _POSITION | _ATTITUDE,
}
"""Messages of the state, and the silences that silence them. ODOMETRY has both parts and stops with either."""
STATE_FIELDS: dict[int, tuple[tuple[set[Part], slice], ...]] = {
    message("ATTITUDE").id: ((_ATTITUDE, slice(1, 7)),),
    message("ATTITUDE_QUATERNION").id: ((_ATTITUDE, slice(1, 8)),),
    message("LOCAL_POSITION_NED").id: ((_POSITION, slice(1, 7)),),
    message("ODOMETRY").id: (
        (_POSITION, slice(1, 4)), (_ATTITUDE, slice(4, 8)), (_POSITION, slice(8, 11)), (_ATTITUDE, slice(11, 14)),
    ),
}  # fmt: skip
"""Where a message has the state in numbers that can be NaN, in wire order."""


class WorldEvents:
    """The events of one flight at work on its ``plant`` and ``sensors``.

    ``any``: whether there are any. ``cut_down``, ``cut_up``: the endpoints nothing comes from or gets to.
    """

    def __init__(self, events: Iterable[Event], plant: Plant, sensors: Sensors) -> None:
        self._script = Script(events)
        self._plant = plant
        self._sensors = sensors
        self._offboard_at: float | None = None
        self._last: list[Happening] = []
        self._not_numbers: list[Part] = []
        self._silent: list[Part] = []
        self.cut_down = self.cut_up = NOBODY
        self.any = bool(self._script)

    def add(self, event: Event) -> None:
        """One more event, in the midst of a flight. Its times count as those of a world's."""
        self._script.add(event)
        self.any = True

    def look(self, t: float, offboard_flown: bool) -> None:
        """Let happen what is due at plant time ``t`` (s)."""
        if offboard_flown and self._offboard_at is None:
            self._offboard_at = t
        for event in self._script.happened(t, self._offboard_at):
            if isinstance(event, EstimatorReset):
                self._sensors.reset(event)
            else:
                self._sensors.jump(event.by)
        lasting = self._script.now(t, self._offboard_at)
        if lasting != self._last:
            self._last = lasting
            self._change(lasting)

    @property
    def alters(self) -> bool:
        """Whether the vehicle says something else, or less, than it should."""
        return bool(self._not_numbers or self._silent)

    def altered(self, msgid: int, values: Values) -> Values | None:
        """What becomes of a message; None: it is not sent."""
        if not SAID_OF_THE_STATE.get(msgid, set()).isdisjoint(self._silent):
            return None
        changed = list(values)
        for parts, where in STATE_FIELDS.get(msgid, ()):
            if not parts.isdisjoint(self._not_numbers):
                changed[where] = [math.nan] * (where.stop - where.start)
        return tuple(changed)

    def _change(self, lasting: list[Happening]) -> None:
        """Other events last than a step ago."""
        plant = self._plant
        winds = [event.wind_n for event in lasting if isinstance(event, Wind)]
        plant.wind_n = winds[-1] if winds else plant.world.wind_n
        pushes = [event.force_n for event in lasting if isinstance(event, Push)]
        plant.push_n = _sum(pushes) if pushes else STILL
        plant.is_held = any(isinstance(event, Hold) for event in lasting)
        failures = [event for event in lasting if isinstance(event, MotorFailure)]
        plant.left = _left(failures) if failures else None
        self._not_numbers = [event.part for event in lasting if isinstance(event, NotANumber)]
        self._silent = [event.part for event in lasting if isinstance(event, Silence)]
        cuts = [event for event in lasting if isinstance(event, LinkCut)]
        self.cut_down = frozenset(endpoint for cut in cuts if cut.down for endpoint in _endpoints(cut))
        self.cut_up = frozenset(endpoint for cut in cuts if cut.up for endpoint in _endpoints(cut))


def _sum(vectors: list[Vec3]) -> Vec3:
    x, y, z = (math.fsum(axis) for axis in zip(*vectors, strict=True))
    return (x, y, z)


def _left(failures: list[MotorFailure]) -> Four:
    left = [1.0, 1.0, 1.0, 1.0]
    for failure in failures:
        left[failure.motor - 1] *= failure.left
    a, b, c, d = left
    return (a, b, c, d)


def _endpoints(cut: LinkCut) -> list[int]:
    return [*([COMPANION] if cut.companion else []), *([GROUND_STATION] if cut.ground_station else [])]
