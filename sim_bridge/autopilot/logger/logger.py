"""PX4's logger: from arming to disarming, the topics that a flight is judged by, at PX4's default periods.

The file lies where PX4's simulation has it, log/DATE/TIME.ulg by the vehicle's UTC clock, and is read by MAVLink FTP.
"""

from __future__ import annotations

import datetime
from collections.abc import Callable
from typing import NamedTuple

from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.logger.ulog import Topic, ULogFile
from sim_bridge.autopilot.messages.parts import NAN, heading_of

STAMP = "uint64_t timestamp"
STAMPS = (STAMP, "uint64_t timestamp_sample")
POSITION = ("x", "y", "z", "vx", "vy", "vz", "heading")
INFO = {"sys_name": "PX4", "ver_hw": "SIM_BRIDGE"}
FILES_KEPT = 5
"""Logs that the vehicle keeps: the oldest goes (engineering choice; PX4 goes by what the card holds)."""
UNUSED = (NAN,) * 8
"""Of the twelve motors that a row has."""
Row = tuple[float, ...]


def _angular_velocity(a: Autopilot) -> Row:
    return (*_stamps(a), *a.estimate.w_b)


def _rates_setpoint(a: Autopilot) -> Row:
    rates = (NAN if rate is None else rate for rate in a.cascade.rates_wanted)
    return (a.estimate.time_us, *rates, 0.0, 0.0, -a.cascade.thrust)


def _attitude(a: Autopilot) -> Row:
    return (*_stamps(a), *a.estimate.q_nb)


def _attitude_setpoint(a: Autopilot) -> Row:
    return (a.estimate.time_us, *a.cascade.attitude_wanted, 0.0, 0.0, -a.cascade.thrust)


def _local_position(a: Autopilot) -> Row:
    return (*_stamps(a), *a.estimate.p_n, *a.estimate.v_n, heading_of(a.estimate.q_nb))


def _motors(a: Autopilot) -> Row:
    return (*_stamps(a), *a.commands, *UNUSED)


def _stamps(a: Autopilot) -> tuple[int, int]:
    return (a.estimate.time_us, a.estimate.time_us)


class Logged(NamedTuple):
    """A topic of the log. ``period_us``: between two of its rows. ``row``: what one has, in the order of its fields."""

    topic: Topic
    period_us: int
    row: Callable[[Autopilot], Row]


LOGGED = (
    Logged(Topic("vehicle_angular_velocity", (*STAMPS, "float[3] xyz")), 20_000, _angular_velocity),
    Logged(
        Topic("vehicle_rates_setpoint", (STAMP, "float roll", "float pitch", "float yaw", "float[3] thrust_body")),
        20_000, _rates_setpoint,
    ),
    Logged(Topic("vehicle_attitude", (*STAMPS, "float[4] q")), 50_000, _attitude),
    Logged(
        Topic("vehicle_attitude_setpoint", (STAMP, "float[4] q_d", "float[3] thrust_body")),
        50_000, _attitude_setpoint,
    ),
    Logged(
        Topic("vehicle_local_position", (*STAMPS, *(f"float {name}" for name in POSITION))), 100_000, _local_position
    ),
    Logged(Topic("actuator_motors", (*STAMPS, "float[12] control")), 100_000, _motors),
)  # fmt: skip
"""Names and fields of PX4's messages, of each the fields that are known here; periods of PX4's default profile
(logged_topics.cpp)."""


class Logger:
    """Writes the log of one vehicle; ``step`` after each of its steps."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self._file: ULogFile | None = None
        self._due_us = [0] * len(LOGGED)

    def step(self) -> None:
        """Begin with arming, end with disarming; what is due is written."""
        if not self._autopilot.commander.armed:
            self._file = None
            return
        now_us = self._autopilot.estimate.time_us
        if self._file is None:
            self._file = self._begin(now_us)
        for number, (_, period_us, row) in enumerate(LOGGED):
            if now_us >= self._due_us[number]:
                self._due_us[number] = now_us + period_us
                self._file.write(number, *row(self._autopilot))

    def _begin(self, now_us: int) -> ULogFile:
        a = self._autopilot
        file = ULogFile([each.topic for each in LOGGED], now_us, INFO)
        at = datetime.datetime.fromtimestamp(1e-6 * (a.unix_us_at_boot + now_us), datetime.UTC)
        a.log_files[f"log/{at:%Y-%m-%d}/{at:%H_%M_%S}.ulg"] = file.data
        while len(a.log_files) > FILES_KEPT:
            del a.log_files[next(iter(a.log_files))]
        self._due_us = [now_us] * len(LOGGED)
        return file
