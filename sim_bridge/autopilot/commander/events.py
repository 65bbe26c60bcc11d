"""EVENT: what PX4 says in numbers beside its texts, for those who are not sent texts.

An id is the hash of the event's name in PX4; who has PX4's table of events can read it in any language. Each event has
a number in one sequence; who has missed one asks for it again.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from typing import NamedTuple

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink.modes import Mode
from companion.mavlink_common import MavSeverity
from sim_bridge.autopilot.commander.commander import Text

EVENT, SEQUENCE = message("EVENT"), message("CURRENT_EVENT_SEQUENCE")
REQUEST, MISSING = message("REQUEST_EVENT"), message("RESPONSE_EVENT_ERROR")
PX4 = 1 << 24
"""The component the ids belong to, in their highest byte."""
KEPT = 20
"""events that can still be asked for (engineering choice)."""
SEQUENCE_PERIOD_US = 3_000_000
"""us between two CURRENT_EVENT_SEQUENCE (recorded)."""
RESET_FLAG = 1
"""MAV_EVENT_CURRENT_SEQUENCE_FLAGS_RESET."""
REASONS = {"external command": 4, "mission start": 5, "landing": 6, "auto preflight disarming": 7, "failsafe": 14}
"""Why the vehicle was armed or disarmed."""
ACTIONS = {
    Mode.POSITION: 2, Mode.ALTITUDE: 3, Mode.STABILIZED: 4, Mode.HOLD: 5, Mode.RETURN: 6, Mode.LAND: 7,
    Mode.DESCEND: 8, Mode.TERMINATION: 10,
}  # fmt: skip
"""Codes of PX4's failsafe actions by the mode they end in, as its event names them."""
PLAIN = {
    "Takeoff detected": 4277609, "Landing detected": 9844908, "Returning to launch": 3484900,
    "Landing at current position": 3322590, "Executing Mission": 15598001, "Mission finished, loitering": 4678390,
    "Mission finished, landed": 7803396, "Pilot took over using sticks": 1746622, "GCS connection regained": 14234660,
    "Connection to ground station lost": 10794072, "Connection to mission computer lost": 11123101,
    "Onboard controller regained": 10716939, "Manual control lost: switching to Hold": 11331989,
    "Unsupported main mode": 2768743, "Unsupported auto mode": 3092229, "Unsupported base mode": 10155243,
    "Arming denied: Resolve system health failures first": 133277, "Disarming denied: not landed": 9091509,
    "Arming denied: throttle not in safe position": 10600202, "Orbit radius limit exceeded": 2087806,
    "Reposition is outside geofence": 13495236, "RTL: land at destination": 185258, "Mission sync timeout": 14440680,
    "Mission start denied! No valid mission": 7067274, "No valid mission available, refusing takeoff": 4854315,
    "No valid mission available, loitering": 3390156, "SET_POSITION_TARGET_LOCAL_NED invalid": 5650341,
    "SET_POSITION_TARGET_LOCAL_NED force not supported": 12815955,
    "Geofence invalid, doesn't contain Home position": 10973461,
    "Geofence invalid, doesn't contain current vehicle position": 9432105,
}  # fmt: skip
"""Texts whose event has no arguments."""
WITH_NUMBERS: tuple[tuple[re.Pattern[str], int, str], ...] = (
    (re.compile(r"Using default takeoff altitude: ([\d.]+) m"), 3878855, "<f"),
    (re.compile(r"Climb to ([\d.-]+) meters above home"), 8208988, "<f"),
    (re.compile(r"RTL: start return at (-?\d+) m \((-?\d+) m above destination\)"), 5383828, "<ii"),
    (re.compile(r"Geofence violation for waypoint (\d+)"), 2831661, "<h"),
    (re.compile(r"SET_POSITION_TARGET_LOCAL_NED coordinate frame (\d+) unsupported"), 11552065, "<B"),
)
"""Texts with numbers: their event's id and the layout of its arguments."""
BY_REASON = {"Armed by ": 9489139, "Disarmed by ": 16017271}
"""Texts with a reason, whose number is the argument."""
FAILSAFE = 14605264
"""Id of PX4's event for a failsafe that acts."""
FAILSAFE_AFTER_HOLD = 4502496
"""Id of PX4's event for a failsafe that holds first."""

LEVELS = {FAILSAFE: 0x42, FAILSAFE_AFTER_HOLD: 0x42} | dict.fromkeys((2768743, 3092229, 10155243), 0x33)
"""Log levels that do not follow from the text's severity."""


class Event(NamedTuple):
    """An event with its number in the sequence. ``levels``: internal and external log level, four bits each."""

    sequence: int
    time_ms: int
    id: int
    levels: int
    arguments: bytes


class Events:
    """The last events of a vehicle. ``last``: the number of the newest; None: there has been none."""

    def __init__(self) -> None:
        self.kept: list[Event] = []
        self._next = 0

    @property
    def last(self) -> int:
        """The number of the newest."""
        return self._next - 1 & 0xFFFF

    def keep_text(self, text: Text, time_us: int, user_intended_mode: Mode, mode: Mode) -> None:
        """Something was said: keep the event that goes with it, if there is one."""
        found = event_of(text.text.rstrip("\t"), user_intended_mode, mode)
        if found is None:
            return
        level = text.severity.value
        internal = MavSeverity.INFO.value if text.severity is MavSeverity.CRITICAL else level
        levels = LEVELS.get(found[0], internal << 4 | level)
        self.keep(found[0], levels, found[1], time_us)

    def keep(self, identity: int, levels: int, arguments: bytes, time_us: int) -> None:
        """One more event."""
        self.kept.append(Event(self._next & 0xFFFF, time_us // 1000, PX4 | identity, levels, arguments))
        del self.kept[:-KEPT]
        self._next += 1


def event_of(text: str, user_intended_mode: Mode, mode: Mode) -> tuple[int, bytes] | None:
    """Id and arguments of the event that goes with a text; None: none does."""
    if text in PLAIN:
        return PLAIN[text], b""
    for beginning, identity in BY_REASON.items():
        if text.startswith(beginning):
            return identity, bytes([REASONS.get(text.removeprefix(beginning), 0)])
    if text == "Failsafe activated":
        return FAILSAFE, struct.pack("<IB", user_intended_mode.custom_mode, ACTIONS.get(mode, 0))
    if text.startswith("Failsafe activated: entering Hold"):
        (seconds,) = re.findall(r"\d+", text)
        return FAILSAFE_AFTER_HOLD, struct.pack(
            "<IBH", user_intended_mode.custom_mode, ACTIONS[Mode.RETURN], int(seconds)
        )
    for pattern, identity, layout in WITH_NUMBERS:
        match = pattern.fullmatch(text)
        if match is not None:
            cast = float if "f" in layout else int
            return identity, struct.pack(layout, *(cast(number) for number in match.groups()))
    return None


class EventLink:
    """One link's side: sends what happens, and again what somebody has missed."""

    def __init__(self, events: Events, system: int, send: Callable[[Format, tuple[Value, ...]], None]) -> None:
        self._events, self._system, self._send = events, system, send
        self._sent = -1
        self._tell_at_us = 0

    def poll(self, now_us: int) -> None:
        """To be called every 10 ms."""
        for event in self._events.kept:
            if (event.sequence - self._sent & 0xFFFF) < 0x8000 and event.sequence != self._sent & 0xFFFF:
                self._sent = event.sequence
                self._tell(event)
        if now_us >= self._tell_at_us:
            flags = RESET_FLAG if self._tell_at_us == 0 else 0
            self._tell_at_us = now_us + SEQUENCE_PERIOD_US
            self._send(SEQUENCE, SEQUENCE.values(sequence=self._events.last, flags=flags))

    def resend(self, frame: Frame) -> None:
        """REQUEST_EVENT: those between two numbers again, as far as they are kept."""
        said = frame.format.named(frame.values)
        if said["target_system"] != self._system or said["target_component"] not in (0, 1):
            return
        first, last = said["first_sequence"], said["last_sequence"]
        kept = {event.sequence: event for event in self._events.kept}
        oldest = self._events.kept[0].sequence if self._events.kept else 0
        for sequence in [(first + i) & 0xFFFF for i in range(min(KEPT, (last - first & 0xFFFF) + 1))]:
            if sequence in kept:
                self._tell(kept[sequence])
            else:
                self._send(MISSING, MISSING.values(
                    target_system=frame.system, target_component=frame.component, sequence=sequence,
                    sequence_oldest_available=oldest,
                ))  # fmt: skip

    def _tell(self, event: Event) -> None:
        self._send(EVENT, EVENT.values(
            id=event.id, event_time_boot_ms=event.time_ms, sequence=event.sequence, log_levels=event.levels,
            arguments=tuple(event.arguments.ljust(40, b"\0")),
        ))  # fmt: skip
