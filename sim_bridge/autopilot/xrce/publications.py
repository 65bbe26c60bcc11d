"""What the vehicle publishes over XRCE, and when: something new, and the shortest interval has passed (PX4's uORB)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial

from companion.xrce.topics import LAYOUTS
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.xrce import samples
from sim_bridge.autopilot.xrce.topic_table import Release, Row, TopicTable

ESTIMATE_US = 8_000
"""us between two samples of the estimator (PX4's simulation)."""
LOOK_US = 10_000
"""us between two looks of the commander at what has changed."""
AGAIN_US = 500_000
"""us after which the commander tells again what has not changed."""
STAMP = 8
"""bytes of a stamp."""

Build = Callable[[Autopilot, int], bytes]


class Periodic:
    """A topic that is new every ``period_us``."""

    def __init__(self, row: Row, build: Build, period_us: int) -> None:
        self.row, self.build = row, build
        self._period_us = period_us
        self._interval_us = round(1e6 / row.rate)
        self._sent_us = -self._interval_us
        self._seen = -1

    def is_due(self, now_us: int) -> bool:
        """Whether to publish."""
        return now_us // self._period_us != self._seen and now_us >= self._sent_us + self._interval_us

    def mark_sent(self, now_us: int) -> None:
        """It is published; a late one brings the next forward, by one interval at most."""
        self._seen = now_us // self._period_us
        self._sent_us = min(now_us, max(now_us - self._interval_us, self._sent_us + self._interval_us))


class OnChange:
    """A topic that is new when it says something else (its stamp apart), and every half a second."""

    def __init__(self, row: Row, build: Build) -> None:
        self.row, self.build = row, build
        self._interval_us = round(1e6 / row.rate)
        self._sent_us = -AGAIN_US
        self._looked, self._changed = -1, False
        self._said = self._new = b""

    def is_due(self, a: Autopilot, now_us: int) -> bool:
        """Whether to publish."""
        if now_us // LOOK_US != self._looked:
            self._looked = now_us // LOOK_US
            self._new = self.build(a, 0)
            self._changed = self._new != self._said
        return now_us >= self._sent_us + (self._interval_us if self._changed else AGAIN_US)

    def publish(self, now_us: int, stamp: int) -> bytes:
        """What was last looked at, with its ``stamp`` (us): a message begins with it."""
        self._sent_us, self._said, self._changed = now_us, self._new, False
        return stamp.to_bytes(STAMP, "little") + self._new[STAMP:]


class Publications:
    """The topics of one vehicle."""

    def __init__(self, autopilot: Autopilot, table: TopicTable, release: Release) -> None:
        self._autopilot = autopilot
        rows = {row.topic.name: row for row in table.given}
        old = release is Release.V1_15
        local, world = (samples.LOCAL_1_15, samples.GLOBAL_1_15) if old else (samples.LOCAL, samples.GLOBAL)
        self._periodic = [
            Periodic(rows["sensor_combined"], samples.sensor_combined, samples.GYRO_US),
            Periodic(rows["vehicle_attitude"], samples.attitude, ESTIMATE_US),
            Periodic(rows["vehicle_local_position"], partial(samples.local_position, layout=local), ESTIMATE_US),
            Periodic(rows["vehicle_global_position"], partial(samples.global_position, layout=world), ESTIMATE_US),
            Periodic(rows["vehicle_odometry"], samples.odometry, ESTIMATE_US),
        ]
        self._on_change = [
            OnChange(rows["vehicle_control_mode"], samples.control_mode),
            OnChange(rows["vehicle_status"], partial(samples.status, layout=samples.STATUS[release])),
            OnChange(rows["vehicle_land_detected"], samples.land_detected),
        ]
        self._rows = rows
        self._queue: deque[tuple[Row, bytes]] = deque(maxlen=16)

    def _gather(self) -> None:
        """Samples that go once, and at once: what the commander says to those who bring modes."""
        said = self._autopilot.commander.external_modes.outbox
        for name, fields in said:
            row = self._rows[name]
            layout = LAYOUTS[name, row.topic.version]
            known = {field: value for field, value in fields.items() if field in layout.fields}
            self._queue.append((row, layout.encode(timestamp=self._autopilot.estimate.time_us, **known)))
        said.clear()

    def is_due(self, now_us: int) -> bool:
        """Whether there is something to publish."""
        a = self._autopilot
        self._gather()
        return (
            bool(self._queue)
            or any(each.is_due(now_us) for each in self._periodic)
            or any(each.is_due(a, now_us) for each in self._on_change)
        )

    def take_due(self, now_us: int, offset_us: int) -> list[tuple[Row, bytes]]:
        """What to publish now, in the order of the table."""
        a = self._autopilot
        stamp = max(0, a.estimate.time_us + offset_us)
        ready = list(self._queue)
        self._queue.clear()
        for periodic in self._periodic:
            if periodic.is_due(now_us):
                periodic.mark_sent(now_us)
                ready.append((periodic.row, periodic.build(a, stamp)))
        for each in self._on_change:
            if each.is_due(a, now_us):
                ready.append((each.row, each.publish(now_us, stamp)))
        return ready

    def tell_time(self, observed_us: int, estimated_us: int, round_trip_us: int) -> None:
        """timesync_status, of one answer of the agent's."""
        sample = samples.timesync(self._autopilot.estimate.time_us, observed_us, estimated_us, round_trip_us)
        self._queue.append((self._rows["timesync_status"], sample))
