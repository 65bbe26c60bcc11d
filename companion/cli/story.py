"""A simulated flight told while it goes on: what happens to the vehicle, what it does about it, why that matters."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from companion.daemon.conductor import Conductor
from companion.record.events import BACK_PATH, BACK_SPEED, START_OFF
from companion.vehicle import Mode
from companion.world import World
from companion.world.events import After, Event, Hold
from companion.world.words import air_in_words, event_in_words

MARK = "  >> "
DEMO = (
    "The paper's circle, 10 m in radius at 3 m/s, flown by its own chain down to the motors.",
    "The vehicle begins 2 m off the path, at a third of the speed, in a light wind. Later it is held still for 3 s.",
    "A controller that follows a timetable would see its reference run away, and chase it when let go. A path has no",
    "clock: the law steers to the near point of the path, and goes on from there.",
)
PLAIN = ("The paper's circle, 10 m in radius at 3 m/s, undisturbed: begins on the path, in still air.",)


@dataclass
class Story:
    """Turns a flight into sentences. ``look`` is asked as often as may be, and says what has become true since."""

    world: World
    _offboard_at: float | None = None
    _armed_at: float | None = None
    _began: bool = False
    _begun: set[Event] = field(default_factory=set)
    _ended: set[Event] = field(default_factory=set)
    _since: float | None = None
    """The vehicle's stamp, s, since which it is on its way back; None where it is back."""
    _error_max: float = 0.0
    _speed_max: float = 0.0

    def opening(self, name: str, seed: int) -> str:
        """The line before the flight: the world, its air, its seed."""
        events = len(self.world.events)
        more = f", {events} event{'s' if events > 1 else ''} to come" if events else ""
        return f"world {name}: {air_in_words(self.world)}; seed {seed}{more}"

    @property
    def has_more(self) -> bool:
        """Whether there may be something to tell yet: a world without events is told once the flight is on its path."""
        return not self._began or self._since is not None or len(self._ended) < len(self.world.events)

    def look(self, conductor: Conductor) -> list[str]:
        """What has happened since the last look, in sentences."""
        tick = conductor.last
        if tick is None or tick.memory.state is None:
            return []
        now = tick.memory.state.t_boot
        if self._armed_at is None and conductor.telemetry.status.last.armed:
            self._armed_at = now
        if self._offboard_at is None and conductor.telemetry.status.last.mode is Mode.OFFBOARD:
            self._offboard_at = now
        steered, progress = tick.outcome.steered, tick.memory.path.progress
        said = self._events(now, progress and progress.path_error, 0.0 if steered is None else steered.command.alpha)
        if steered is None or progress is None or tick.memory.path.follow_from is None:
            return said
        error, speed, alpha = progress.path_error, abs(steered.command.speed), abs(steered.command.alpha)
        if not self._began:
            self._began = True
            if error > START_OFF:
                self._set_out(now)
                said.append(
                    f"{MARK}begins {error:.1f} m off the path at {speed:z.1f} of {alpha:z.1f} m/s: it heads for the "
                    "near point of the path, not for a place where it should be by now"
                )
        if self._since is not None:
            self._error_max, self._speed_max = max(self._error_max, error), max(self._speed_max, speed)
            if error <= BACK_PATH and abs(speed - alpha) <= BACK_SPEED * alpha:
                said.append(
                    f"{MARK}on the path at {speed:z.1f} m/s after {now - self._since:.1f} s; on the way it was at most "
                    f"{self._error_max:.2f} m from the path and never faster than {self._speed_max:.1f} m/s"
                )
                self._since = None
        return said

    def _zero(self, after: After) -> float | None:
        """What the times of an event count from, s of the vehicle's stamps; None where it has not been yet."""
        return 0.0 if after is After.START else self._armed_at if after is After.ARMED else self._offboard_at

    def _set_out(self, now: float) -> None:
        self._since, self._error_max, self._speed_max = now, 0.0, 0.0

    def _events(self, now: float, error: float | None, alpha: float) -> list[str]:
        said = []
        for event in self.world.events:
            zero = self._zero(event.when.after)
            if zero is None:
                continue
            begin, end = zero + event.when.begin, zero + event.when.end
            if now >= begin and event not in self._begun:
                self._begun.add(event)
                lasts = f" for {end - begin:g} s" if math.isfinite(end) and end > begin else ""
                said.append(f"{MARK}{event_in_words(event)}{lasts}")
            if now >= end > begin and event not in self._ended:
                self._ended.add(event)
                said.append(MARK + _over(event, error, alpha))
                self._set_out(end)
        return said


def _over(event: Event, error: float | None, alpha: float) -> str:
    if not isinstance(event, Hold) or error is None:
        return f"over: {event_in_words(event)}"
    near = f"{100.0 * error:.0f} cm" if error < 1.0 else f"{error:.1f} m"
    ahead = abs(alpha) * (event.when.end - event.when.begin)
    return (
        f"let go: a timetable would be {ahead:.1f} m ahead by now, to be chased; the near point of the path is {near} "
        "away, and the flight goes on from there"
    )
