"""A command, what it may do to the link it came by, and how PX4 reads its numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

from companion.mavlink_common import MAV_COMP_ID_MISSIONPLANNER, MavResult
from sim_bridge.autopilot.autopilot import Autopilot

NOT_GIVEN = 2**31 - 1
"""What COMMAND_INT says for a coordinate that is not given."""
_CAST_LOW = 2.0**31 - 128.0
"""The largest float32 below it."""
_CAST_HIGH = 2.0**31 + 256.0
"""The smallest float32 above 2**31."""


class Command(NamedTuple):
    """A command: its id, its seven parameters (NaN where not given), and who sent it."""

    id: int
    parameters: tuple[float, float, float, float, float, float, float]
    system: int
    component: int

    @property
    def is_operators(self) -> bool:
        """Whether a ground station sent it: only such a one is told in words why a mode was refused."""
        return self.component == MAV_COMP_ID_MISSIONPLANNER


class Wire(Protocol):
    """What a command can do to the link it came by."""

    def request(self, msgid: int, argument: float) -> bool:
        """Send a message now. False: there is no such message, or it has nothing to say."""

    def tell_interval(self, msgid: int) -> None:
        """Send MESSAGE_INTERVAL for a message."""

    def set_interval(self, msgid: int, interval_us: int) -> bool:
        """Change a stream's interval. False: it cannot be."""


Handler = Callable[[Command, Autopilot, Wire], MavResult | None]


def accept(command: Command, autopilot: Autopilot, wire: Wire) -> MavResult:
    """A command that PX4 accepts and that changes nothing here."""
    return MavResult.ACCEPTED


def is_integer_max(value: float) -> bool:
    """Whether a float is INT32_MAX, cast: somebody sent a COMMAND_INT's "not given" in a COMMAND_LONG."""
    return _CAST_LOW <= value <= _CAST_HIGH


def whole(value: float) -> int:
    """A parameter that means a whole number; 0 where it is none, as a cast on PX4's processor gives."""
    return round(value) if math.isfinite(value) and abs(value) < 2**31 else 0


def byte(value: float) -> int:
    """The same, cut to eight bits."""
    return int(value) & 0xFF if math.isfinite(value) and abs(value) < 2**31 else 0
