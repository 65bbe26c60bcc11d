"""When the vehicle says what: streams with intervals, capped by how often their source is renewed.

Times are microseconds of the bridge's own clock, which runs even while the vehicle's is held.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from companion.mavlink.dialect import BY_NAME
from sim_bridge.autopilot.mavlink.stream_table import ESTIMATOR_US, SILENT, TABLE, Row

STOPPED = -1
"""The interval of a stream that is off; also what PX4 tells of one that is not limited."""
FIXED = frozenset({BY_NAME["HEARTBEAT"].id})
"""Streams whose interval nobody may change."""
RETRY_US = 20_000
"""us until a stream that had nothing to send is looked at again."""
NOTHING: Sequence[int] = ()


class Profile(enum.Enum):
    """Who is at the other end of a link."""

    ONBOARD = 0
    GROUND_STATION = 1

    def rate(self, row: Row) -> float | None:
        """The default rate, Hz; None: off."""
        return row[self.value]


ONBOARD, GROUND_STATION = Profile


class Boot(NamedTuple):
    """When a vehicle that has just been switched on begins to talk, s."""

    streams: float = 0.2
    heartbeat: float = 0.9


@dataclass(slots=True)
class Stream:
    """One message's stream: its default interval, its interval now, how often its source is renewed (us).

    ``reported_us``: the interval as MESSAGE_INTERVAL tells it. ``queued_us``: when it is looked at next; None: never.
    """

    default_us: int
    default_reported_us: int
    interval_us: int
    reported_us: int
    source_us: int
    since_us: int
    is_sent: bool
    due_us: int = 0
    queued_us: int | None = None


class Streams:
    """The streams of one link. ``step_us``: the bridge's step.

    ``direct``: the plant's own estimator runs at every step; otherwise PX4's ceilings hold. ``only``: the messages
    that are sent at all, by their ids; None: every one that PX4 sends.
    """

    def __init__(
        self, profile: Profile, step_us: int, *, direct: bool, boot: Boot | None, only: Collection[int] | None = None
    ) -> None:
        self._streams: dict[int, Stream] = {}
        self._calendar: dict[int, list[int]] = {}  # time -> the messages to send then
        self._now = 0
        self._step_us = step_us
        rows = {BY_NAME[name].id: row for name, row in TABLE.items()}
        for msgid, row in (rows | SILENT).items():
            source = step_us if direct and row.source_us <= ESTIMATOR_US else max(step_us, row.source_us)
            interval, reported = _intervals(profile.rate(row), source)
            since = 0.0 if boot is None else boot.heartbeat if msgid in FIXED else boot.streams
            is_sent = msgid in rows and (only is None or msgid in only)
            stream = Stream(interval, reported, interval, reported, source, round(since * 1e6), is_sent)
            self._streams[msgid] = stream
            self._schedule(msgid, stream, max(step_us, stream.since_us))

    def interval(self, msgid: int) -> int:
        """The interval of a stream, us; STOPPED where there is none or it is off."""
        stream = self._streams.get(msgid)
        return STOPPED if stream is None else stream.reported_us

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        """Change a stream: 0 back to its default, negative stops it. False: there is no such stream to change."""
        stream = self._streams.get(msgid)
        if stream is None or msgid in FIXED:
            return False
        if interval_us == 0:
            stream.interval_us, stream.reported_us = stream.default_us, stream.default_reported_us
        else:
            stream.interval_us = stream.reported_us = max(STOPPED, interval_us)
        self._forget(msgid, stream)
        self._schedule(msgid, stream, max(self._now + 1, stream.since_us))
        return True

    def due(self, now_us: int) -> Sequence[int]:
        """The messages to send at ``now_us``, each once; ``again`` is to be called for each of them.

        To be asked at every step: what is missed is never sent.
        """
        self._now = now_us
        return self._calendar.pop(now_us, NOTHING)

    def again(self, msgid: int, sent: bool) -> None:
        """A message that was due has been sent, or had nothing to say: when it is next."""
        stream = self._streams[msgid]
        now_us = self._now
        # From the time it was due, so that the mean rate is right; not to catch up on what a source cannot give.
        due_us = stream.due_us + stream.interval_us if sent else now_us + RETRY_US
        self._schedule(msgid, stream, due_us if due_us > now_us else now_us + 1)

    def _schedule(self, msgid: int, stream: Stream, due_us: int) -> None:
        """Queue the next sending, at the first step after the source's first renewal that is not before ``due_us``."""
        if stream.interval_us == STOPPED or not stream.is_sent:
            stream.queued_us = None
            return
        stream.due_us = due_us
        source_us = stream.source_us
        renewed = -(-due_us // source_us) * source_us
        if source_us % self._step_us:
            renewed = -(-renewed // self._step_us) * self._step_us
        stream.queued_us = renewed
        messages = self._calendar.get(renewed)
        if messages is None:
            self._calendar[renewed] = [msgid]
        else:
            messages.append(msgid)

    def _forget(self, msgid: int, stream: Stream) -> None:
        """Take a stream out of the calendar."""
        if stream.queued_us is not None:
            messages = self._calendar.get(stream.queued_us)
            if messages is not None and msgid in messages:
                messages.remove(msgid)
            stream.queued_us = None


def _intervals(rate: float | None, source_us: int) -> tuple[int, int]:
    """The interval of a default rate and the interval that is told, us."""
    if rate is None:
        return STOPPED, STOPPED
    if math.isinf(rate):
        return source_us, STOPPED
    interval = int(1e6 / rate)  # PX4 cuts
    return interval, interval
