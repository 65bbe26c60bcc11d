"""When something happens in a world."""

from __future__ import annotations

import enum
import math
from typing import NamedTuple


class After(enum.Enum):
    """What the times of an event count from."""

    START = "start"
    """the plant's start"""
    ARMED = "armed"
    """the first arming"""
    OFFBOARD = "offboard"
    """the first setpoint that is flown in OFFBOARD"""


class When(NamedTuple):
    """From ``begin`` until ``end``, s, counted from ``after``; what happens once happens at ``begin``."""

    begin: float
    end: float = math.inf
    after: After = After.START
