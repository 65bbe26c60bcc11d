"""When an event of a world file happens: at a time, or from one until another."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from companion.config.syntax.schema import Strict
from companion.world.when import After, When

Time = Annotated[float, Field(ge=0.0, le=1e5)]
AfterName = Literal["start", "armed", "offboard"]


class Once(Strict):
    """At a time."""

    at_s: Time
    """when, in s"""
    after: AfterName = "start"
    """what the time counts from: the plant's start, the first arming, the first setpoint flown in OFFBOARD
    (start, armed, offboard)"""

    @property
    def when(self) -> When:
        return When(self.at_s, self.at_s, After(self.after))


class While(Strict):
    """From a time until another."""

    from_s: Time
    """from when, in s"""
    to_s: Time | None = None
    """until when, in s; for good where absent"""
    after: AfterName = "start"
    """what the times count from: the plant's start, the first arming, the first setpoint flown in OFFBOARD
    (start, armed, offboard)"""

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> While:
        if self.to_s is not None and self.to_s <= self.from_s:
            raise ValueError(f"ends at {self.to_s:g} s but begins at {self.from_s:g} s; expected to_s after from_s")
        return self

    @property
    def when(self) -> When:
        return When(self.from_s, math.inf if self.to_s is None else self.to_s, After(self.after))
