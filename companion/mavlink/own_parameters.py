"""Our own parameters, as a component of the vehicle: a ground station shows them and sets them in flight.

MAVLink's parameter protocol, the other side of it; every value is a real number within its range.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import (
    MAV_PARAM_TYPE_REAL32,
)

LIST, READ, SET = message("PARAM_REQUEST_LIST"), message("PARAM_REQUEST_READ"), message("PARAM_SET")
VALUE = message("PARAM_VALUE")
WANTED = frozenset({LIST.id, READ.id, SET.id})
EVERYBODY = 0
"""The target system 0."""


@dataclass
class Own:
    """One parameter: its value and the range it may be set to. A value out of range becomes the nearest within."""

    value: float
    low: float
    high: float


@dataclass
class OwnParameters:
    """What component ``component`` offers under ``names`` (16 characters at most). ``send`` queues a message.
    ``locked``: the names that may not be set now, and why."""

    send: Callable[[Format, tuple[Value, ...]], None]
    component: int
    named: dict[str, Own] = field(default_factory=dict)
    locked: tuple[frozenset[str], str] = (frozenset(), "")

    def receive(self, frame: Frame, system: int) -> str | None:
        """Answer a frame that is meant for us, ``system`` being our vehicle's. A line for people where one was set."""
        if frame.format.id not in WANTED:
            return None
        values = frame.format.named(frame.values)
        if values["target_system"] != system or values["target_component"] not in (self.component, EVERYBODY):
            return None
        if frame.format is LIST:
            for name in self.named:
                self.tell(name)
            return None
        name = values["param_id"]
        if frame.format is READ and 0 <= values["param_index"] < len(self.named):
            name = list(self.named)[values["param_index"]]
        own = self.named.get(name)
        if own is None:
            return None
        note = None
        if frame.format is SET and math.isfinite(values["param_value"]):
            names, why = self.locked
            if name in names:
                note = f"{name} stays {own.value:g}: {why}"
            else:
                own.value = min(max(values["param_value"], own.low), own.high)
                note = f"{name} set to {own.value:g} by the ground station"
        self.tell(name)
        return note

    def tell(self, name: str) -> None:
        """Tell a parameter's value, asked or not."""
        index = list(self.named).index(name)
        self.send(VALUE, VALUE.values(
            param_value=self.named[name].value, param_count=len(self.named), param_index=index, param_id=name,
            param_type=MAV_PARAM_TYPE_REAL32,
        ))  # fmt: skip
