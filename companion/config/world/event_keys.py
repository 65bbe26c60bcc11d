"""What happens in a world, as its file writes it."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from companion.config.world.actor_keys import AUTOPILOTS, TYPES, ActorModel, AutopilotName, TypeName
from companion.config.world.event_times import Once, While
from companion.config.world.link_event_keys import LinkEventModel
from companion.world import events
from companion.world.events import Event, Part, Stamps

Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Mps = Annotated[float, Field(ge=-50.0, le=50.0)]
Newtons = Annotated[float, Field(ge=-1e4, le=1e4)]
Three = Annotated[list[Annotated[float, Field(ge=-1e4, le=1e4)]], Field(min_length=3, max_length=3)]
VALUES = {"nan": math.nan, "infinite": math.inf, "huge": 3e38}
"""What a number on the wire may be instead: the last is near the largest of a float32."""


def _zero() -> list[float]:
    return [0.0, 0.0, 0.0]


class PushModel(While):
    """A force on the centre of mass."""

    kind: Literal["push"]
    """the kind of event"""
    force_n: Annotated[list[Newtons], Field(min_length=3, max_length=3)]
    """the force [north, east, down], in N"""

    def event(self) -> Event:
        north, east, down = self.force_n
        return events.Push(self.when, (north, east, down))


class HoldModel(While):
    """Somebody holds the vehicle and lets go again."""

    kind: Literal["hold"]
    """the kind of event"""

    def event(self) -> Event:
        return events.Hold(self.when)


class WindModel(While):
    """Another wind for a while."""

    kind: Literal["wind"]
    """the kind of event"""
    wind_mps: Annotated[list[Mps], Field(min_length=3, max_length=3)]
    """the mean velocity of the air over the ground [north, east, down], in m/s"""

    def event(self) -> Event:
        north, east, down = self.wind_mps
        return events.Wind(self.when, (north, east, down))


class MotorFailureModel(While):
    """A motor gives less than it should."""

    kind: Literal["motor_failure"]
    """the kind of event"""
    motor: Annotated[int, Field(ge=1, le=4)] | None = None
    """which motor in the autopilot's order, 1..4; every one where absent"""
    thrust_left: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """what is left of its thrust, 0..1"""

    def event(self) -> Event:
        return events.MotorFailure(self.when, self.motor, self.thrust_left)


class PayloadDropModel(Once):
    """A payload falls off: the mass is less from then on."""

    kind: Literal["payload_drop"]
    """the kind of event"""
    mass_kg: Annotated[float, Field(gt=0.0, le=100.0)]
    """how much lighter the vehicle is then, three quarters of its mass at most, in kg"""

    def event(self) -> Event:
        return events.PayloadDrop(self.when, self.mass_kg)


class EstimatorResetModel(Once):
    """The estimate jumps."""

    kind: Literal["estimator_reset"]
    """the kind of event"""
    position_m: Annotated[list[Metres], Field(min_length=3, max_length=3)] = Field(default_factory=_zero)
    """how far the position jumps [north, east, down], in m"""
    velocity_mps: Annotated[list[Mps], Field(min_length=3, max_length=3)] = Field(default_factory=_zero)
    """how far the velocity jumps [north, east, down], in m/s"""
    yaw_deg: Annotated[float, Field(ge=-180.0, le=180.0)] = 0.0
    """how far the heading jumps, clockwise from above, in degrees"""
    counted: bool = True
    """whether the vehicle's reset counter counts it, as PX4's does"""

    def event(self) -> Event:
        (x, y, z), (u, v, w) = self.position_m, self.velocity_mps
        return events.EstimatorReset(self.when, (x, y, z), (u, v, w), math.radians(self.yaw_deg), self.counted)


class ClockJumpModel(Once):
    """The vehicle's stamps jump."""

    kind: Literal["clock_jump"]
    """the kind of event"""
    by_s: Annotated[float, Field(ge=-1e4, le=1e4)]
    """how far the stamps jump, in s"""

    def event(self) -> Event:
        return events.ClockJump(self.when, self.by_s)


class NanStateModel(While):
    """The state the vehicle sends is not a number."""

    kind: Literal["nan_state"]
    """the kind of event"""
    part: Literal["position", "attitude", "state"] = "state"
    """what is not a number: position (and velocity), attitude (and rates), or the whole state"""
    value: Literal["nan", "infinite", "huge"] = "nan"
    """what it is instead: nan, infinite, or a number as large as fits on the wire (huge)"""

    def event(self) -> Event:
        return events.NotANumber(self.when, Part(self.part), VALUES[self.value])


class SilenceModel(While):
    """The vehicle stops sending a part of its state."""

    kind: Literal["silence"]
    """the kind of event"""
    part: Literal["position", "attitude", "state"] = "state"
    """what is no longer sent: position (and velocity), attitude (and rates), or the whole state"""

    def event(self) -> Event:
        return events.Silence(self.when, Part(self.part))


class FrozenStateModel(While):
    """A part of the state the vehicle sends stays as it was, while velocity and rates go on."""

    kind: Literal["frozen_state"]
    """the kind of event"""
    part: Literal["position", "attitude", "state"] = "position"
    """what stays: position, attitude, or both (state)"""
    noise: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """the standard deviation of the white noise on it, in m (position) and 1 (each number of the quaternion)"""

    def event(self) -> Event:
        return events.FrozenState(self.when, Part(self.part), self.noise)


class OffsetStateModel(While):
    """The state the vehicle sends is off by so much, and no reset counter counts."""

    kind: Literal["offset_state"]
    """the kind of event"""
    position_m: Three = Field(default_factory=_zero)
    """how far off the position is [north, east, down], in m"""
    velocity_mps: Three = Field(default_factory=_zero)
    """how far off the velocity is [north, east, down], in m/s"""
    yaw_deg: Annotated[float, Field(ge=-180.0, le=180.0)] = 0.0
    """how far off the heading is, clockwise from above, in degrees"""

    def event(self) -> Event:
        (x, y, z), (u, v, w) = self.position_m, self.velocity_mps
        return events.OffsetState(self.when, (x, y, z), (u, v, w), math.radians(self.yaw_deg))


class WrongStampsModel(While):
    """The stamps of the state the vehicle sends are wrong."""

    kind: Literal["wrong_stamps"]
    """the kind of event"""
    stamps: Literal["zero", "frozen", "milliseconds", "huge"] = "zero"
    """what they are: always 0, always the same (frozen), in milliseconds where microseconds belong, or the largest
    number there is (huge)"""

    def event(self) -> Event:
        return events.WrongStamps(self.when, Stamps(self.stamps))


class OdometryFramesModel(While):
    """ODOMETRY comes in other frames than PX4's."""

    kind: Literal["odometry_frames"]
    """the kind of event"""
    pose: Annotated[int, Field(ge=0, le=255)] = 1
    """frame_id, a MAV_FRAME (no unit): 1 is LOCAL_NED, 4 LOCAL_ENU, 18 LOCAL_FRD"""
    velocity: Annotated[int, Field(ge=0, le=255)] = 1
    """child_frame_id, a MAV_FRAME (no unit): 1 is LOCAL_NED, 8 BODY_NED, 12 BODY_FRD"""

    def event(self) -> Event:
        return events.OdometryFrames(self.when, self.pose, self.velocity)


class ImpostorModel(While):
    """The vehicle's own heartbeats say that it is something else than a PX4 quadrotor."""

    kind: Literal["impostor"]
    """the kind of event"""
    type: TypeName = "quadrotor"
    """what it says it is: fixed_wing, quadrotor, rover, ..."""
    autopilot: AutopilotName = "px4"
    """its autopilot: px4, ardupilot, none"""

    def event(self) -> Event:
        return events.Impostor(self.when, TYPES[self.type], AUTOPILOTS[self.autopilot])


EventModel = Annotated[
    PushModel | HoldModel | WindModel | MotorFailureModel | PayloadDropModel | EstimatorResetModel | ClockJumpModel
    | NanStateModel | SilenceModel | FrozenStateModel | OffsetStateModel | WrongStampsModel | OdometryFramesModel
    | ImpostorModel | LinkEventModel | ActorModel,
    Field(discriminator="kind"),
]  # fmt: skip
