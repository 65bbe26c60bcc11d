"""When the vehicle says what: streams with intervals, capped by how often their source is renewed.

Times are microseconds of the bridge's own clock, which runs even while the vehicle's is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from companion.mavlink.dialect import BY_NAME

STOPPED = -1
"""The interval of a stream that is off."""
FIXED = frozenset({BY_NAME["HEARTBEAT"].id})
"""Streams whose interval nobody may change."""
HIGH_RATE_US = 4000
"""The period of PX4's gyro and attitude in simulation."""
ESTIMATOR_US = 8000
"""The period of PX4's estimator in simulation: what caps position and odometry."""

ONBOARD: dict[str, float] = {
    "ATTITUDE": 100.0,
    "ATTITUDE_QUATERNION": 50.0,
    "GLOBAL_POSITION_INT": 50.0,
    "HIGHRES_IMU": 50.0,
    "LOCAL_POSITION_NED": 30.0,
    "ODOMETRY": 30.0,
    "TIMESYNC": 10.0,
    "EXTENDED_SYS_STATE": 5.0,
    "SYS_STATUS": 5.0,
    "HEARTBEAT": 1.0,
    "PING": 1.0,
    "BATTERY_STATUS": 0.5,
    "CURRENT_MODE": 0.5,
    "HOME_POSITION": 0.5,
}
"""Hz, what PX4 sends a companion by default."""
GROUND_STATION: dict[str, float] = {
    "ATTITUDE": 50.0,
    "ATTITUDE_QUATERNION": 50.0,
    "GLOBAL_POSITION_INT": 50.0,
    "LOCAL_POSITION_NED": 50.0,
    "EXTENDED_SYS_STATE": 1.0,
    "SYS_STATUS": 1.0,
    "HEARTBEAT": 1.0,
    "BATTERY_STATUS": 0.5,
    "CURRENT_MODE": 0.5,
    "HOME_POSITION": 0.5,
    "PING": 0.1,
}
"""Hz, what PX4 sends a ground station by default."""
ON_REQUEST = ("ACTUATOR_OUTPUT_STATUS", "ATTITUDE", "HIGHRES_IMU", "HIL_STATE_QUATERNION", "ODOMETRY", "TIMESYNC")
"""Streams that exist on every link, off where they are not on by default."""
BY_ESTIMATOR = frozenset({"LOCAL_POSITION_NED", "ODOMETRY", "GLOBAL_POSITION_INT"})


NOTHING: Sequence[int] = ()


class Boot(NamedTuple):
    """When a vehicle that has just been switched on begins to talk, s."""

    streams: float = 0.2
    heartbeat: float = 0.9
    position: float = 2.7


@dataclass(slots=True)
class Stream:
    """One message's stream: its default interval, its interval now, and how often its source is renewed (us)."""

    default_us: int
    interval_us: int
    source_us: int
    since_us: int
    due_us: int


class Streams:
    """The streams of one link. ``rates``: Hz by message name. ``step_us``: the bridge's step.

    ``direct``: the plant's own estimator runs at every step; otherwise PX4's ceilings hold.
    """

    def __init__(self, rates: dict[str, float], step_us: int, *, direct: bool, boot: Boot | None) -> None:
        self._streams: dict[int, Stream] = {}
        self._calendar: dict[int, list[int]] = {}  # time -> the messages to send then
        self._now = 0
        for name in dict.fromkeys((*rates, *ON_REQUEST)):
            source = step_us if direct else max(step_us, ESTIMATOR_US if name in BY_ESTIMATOR else HIGH_RATE_US)
            interval = round(1e6 / rates[name]) if name in rates else STOPPED
            since = 0.0 if boot is None else boot.heartbeat if name == "HEARTBEAT" else boot.streams
            if boot is not None and name == "GLOBAL_POSITION_INT":
                since = boot.position
            stream = Stream(interval, interval, source, round(since * 1e6), 0)
            self._streams[BY_NAME[name].id] = stream
            self._schedule(BY_NAME[name].id, stream, max(step_us, stream.since_us))

    def interval(self, msgid: int) -> int:
        """The interval of a stream, us; STOPPED where there is none or it is off."""
        stream = self._streams.get(msgid)
        return STOPPED if stream is None else stream.interval_us

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        """Change a stream: 0 back to its default, negative stops it. False: there is no such stream to change."""
        stream = self._streams.get(msgid)
        if stream is None or msgid in FIXED:
            return False
        stream.interval_us = stream.default_us if interval_us == 0 else max(STOPPED, interval_us)
        for messages in self._calendar.values():
            if msgid in messages:
                messages.remove(msgid)
        self._schedule(msgid, stream, max(self._now + 1, stream.since_us))
        return True

    def due(self, now_us: int) -> Sequence[int]:
        """The messages to send at ``now_us``, each once. To be asked at every step: what is missed is never sent."""
        self._now = now_us
        messages = self._calendar.pop(now_us, NOTHING)
        for msgid in messages:
            stream = self._streams[msgid]
            # From the time it was due, so that the mean rate is right; not to catch up on what a source cannot give.
            due_us = stream.due_us + stream.interval_us
            self._schedule(msgid, stream, due_us if due_us > now_us else now_us + 1)
        return messages

    def _schedule(self, msgid: int, stream: Stream, due_us: int) -> None:
        """Queue the next sending, at the first renewal of the source that is not before ``due_us``."""
        if stream.interval_us != STOPPED:
            stream.due_us = due_us
            renewed = -(-due_us // stream.source_us) * stream.source_us
            messages = self._calendar.get(renewed)
            if messages is None:
                self._calendar[renewed] = [msgid]
            else:
                messages.append(msgid)
