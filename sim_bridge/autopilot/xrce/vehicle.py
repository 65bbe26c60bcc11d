"""The vehicle as its XRCE client sees it: its clock, what it publishes, what is written to it."""

from __future__ import annotations

from companion.xrce.topics import Topic
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.xrce.client import Client
from sim_bridge.autopilot.xrce.publications import Publications
from sim_bridge.autopilot.xrce.subscriptions import Subscriptions
from sim_bridge.autopilot.xrce.topic_table import Release, Row, table_of


class XrceVehicle:
    """One autopilot, as a PX4 of ``release`` shows it. ``client``: its line to the agent."""

    def __init__(self, autopilot: Autopilot, release: Release) -> None:
        table = table_of(release)
        self._autopilot = autopilot
        self._publications = Publications(autopilot, table, release)
        self._subscriptions = Subscriptions(autopilot, versioned=release is not Release.V1_15)
        self.client = Client(table, self)

    @property
    def key(self) -> int:
        return int(self._autopilot.parameters["UXRCE_DDS_KEY"])

    @property
    def synchronises(self) -> bool:
        return self._autopilot.parameters["UXRCE_DDS_SYNCT"] > 0

    @property
    def clock_us(self) -> int:
        return max(1, round(self._autopilot.t * 1e6))  # 0 is no time; a vehicle that is held stands at it

    def is_due(self, now_us: int) -> bool:
        return self._publications.is_due(now_us)

    def take_samples(self, now_us: int, offset_us: int) -> list[tuple[Row, bytes]]:
        return self._publications.take_due(now_us, offset_us)

    def take(self, topic: Topic, sample: bytes, offset_us: int) -> None:
        self._subscriptions.take(topic, sample, offset_us)

    def notice_time(self, observed_us: int, offset_us: int, round_trip_us: int) -> None:
        self._publications.tell_time(observed_us, offset_us, round_trip_us)
