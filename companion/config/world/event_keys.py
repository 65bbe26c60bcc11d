"""What happens in a world, as its file writes it."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from companion.config.syntax.schema import Strict
from companion.world import events
from companion.world.events import Event, Part, When

Time = Annotated[float, Field(ge=0.0, le=1e5)]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Mps = Annotated[float, Field(ge=-50.0, le=50.0)]
Newtons = Annotated[float, Field(ge=-1e4, le=1e4)]
After = Literal["start", "offboard"]


class _Once(Strict):
    """At a time."""

    at_s: Time
    """when, in s"""
    after: After = "start"
    """what the time counts from: the plant's start, or the first setpoint flown in OFFBOARD (start, offboard)"""

    @property
    def when(self) -> When:
        return When(self.at_s, self.at_s, self.after == "offboard")


class _While(Strict):
    """From a time until another."""

    from_s: Time
    """from when, in s"""
    to_s: Time | None = None
    """until when, in s; for good where absent"""
    after: After = "start"
    """what the times count from: the plant's start, or the first setpoint flown in OFFBOARD (start, offboard)"""

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> _While:
        if self.to_s is not None and self.to_s <= self.from_s:
            raise ValueError(f"ends at {self.to_s:g} s but begins at {self.from_s:g} s; expected to_s after from_s")
        return self

    @property
    def when(self) -> When:
        return When(self.from_s, math.inf if self.to_s is None else self.to_s, self.after == "offboard")


class PushModel(_While):
    """A force on the centre of mass."""

    kind: Literal["push"]
    """the kind of event"""
    force_n: Annotated[list[Newtons], Field(min_length=3, max_length=3)]
    """the force [north, east, down], in N"""

    def event(self) -> Event:
        north, east, down = self.force_n
        return events.Push(self.when, (north, east, down))


class HoldModel(_While):
    """Somebody holds the vehicle and lets go again."""

    kind: Literal["hold"]
    """the kind of event"""

    def event(self) -> Event:
        return events.Hold(self.when)


class WindModel(_While):
    """Another wind for a while."""

    kind: Literal["wind"]
    """the kind of event"""
    wind_mps: Annotated[list[Mps], Field(min_length=3, max_length=3)]
    """the mean velocity of the air over the ground [north, east, down], in m/s"""

    def event(self) -> Event:
        north, east, down = self.wind_mps
        return events.Wind(self.when, (north, east, down))


class MotorFailureModel(_While):
    """A motor gives less than it should."""

    kind: Literal["motor_failure"]
    """the kind of event"""
    motor: Annotated[int, Field(ge=1, le=4)]
    """which motor in the autopilot's order, 1..4"""
    thrust_left: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """what is left of its thrust, 0..1"""

    def event(self) -> Event:
        return events.MotorFailure(self.when, self.motor, self.thrust_left)


class EstimatorResetModel(_Once):
    """The estimate jumps."""

    kind: Literal["estimator_reset"]
    """the kind of event"""
    position_m: Annotated[list[Metres], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0]
    )
    """how far the position jumps [north, east, down], in m"""
    velocity_mps: Annotated[list[Mps], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0]
    )
    """how far the velocity jumps [north, east, down], in m/s"""
    yaw_deg: Annotated[float, Field(ge=-180.0, le=180.0)] = 0.0
    """how far the heading jumps, clockwise from above, in degrees"""

    def event(self) -> Event:
        (x, y, z), (u, v, w) = self.position_m, self.velocity_mps
        return events.EstimatorReset(self.when, (x, y, z), (u, v, w), math.radians(self.yaw_deg))


class ClockJumpModel(_Once):
    """The vehicle's stamps jump."""

    kind: Literal["clock_jump"]
    """the kind of event"""
    by_s: Annotated[float, Field(ge=-1e4, le=1e4)]
    """how far the stamps jump, in s"""

    def event(self) -> Event:
        return events.ClockJump(self.when, self.by_s)


class NanStateModel(_While):
    """The state the vehicle sends is not a number."""

    kind: Literal["nan_state"]
    """the kind of event"""
    part: Literal["position", "attitude", "state"] = "state"
    """what is not a number: position (and velocity), attitude (and rates), or the whole state"""

    def event(self) -> Event:
        return events.NotANumber(self.when, Part(self.part))


class SilenceModel(_While):
    """The vehicle stops sending a part of its state."""

    kind: Literal["silence"]
    """the kind of event"""
    part: Literal["position", "attitude", "state"] = "state"
    """what is no longer sent: position (and velocity), attitude (and rates), or the whole state"""

    def event(self) -> Event:
        return events.Silence(self.when, Part(self.part))


class LinkCutModel(_While):
    """The link is cut."""

    kind: Literal["link_cut"]
    """the kind of event"""
    way: Literal["both", "down", "up"] = "both"
    """which way: down (vehicle to companion), up (companion to vehicle), both"""
    link: Literal["companion", "ground_station", "both"] = "companion"
    """whose link: companion, ground_station, both"""

    def event(self) -> Event:
        return events.LinkCut(
            self.when, self.way != "up", self.way != "down", self.link != "ground_station", self.link != "companion"
        )


EventModel = Annotated[
    PushModel | HoldModel | WindModel | MotorFailureModel | EstimatorResetModel | ClockJumpModel | NanStateModel
    | SilenceModel | LinkCutModel,
    Field(discriminator="kind"),
]  # fmt: skip
