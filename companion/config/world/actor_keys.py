"""Who acts beside vehicle and companion, as a world file writes it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from companion import mavlink_common as mav
from companion.config.world.event_times import Once, While
from companion.world import events
from companion.world.events import Event, Order, Saying

OrderName = Literal[
    "hold", "land", "return", "position", "altitude", "stabilized", "mission", "offboard", "take_off", "arm", "disarm",
    "kill", "terminate",
]  # fmt: skip
ModeName = Literal["hold", "land", "return", "position", "altitude", "stabilized", "mission", "offboard", "take_off"]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Byte = Annotated[int, Field(ge=1, le=255)]
Stick = Annotated[float, Field(ge=-1.0, le=1.0)]
TYPES = {
    "fixed_wing": mav.MAV_TYPE_FIXED_WING,
    "quadrotor": mav.MAV_TYPE_QUADROTOR,
    "helicopter": mav.MAV_TYPE_HELICOPTER,
    "ground_station": mav.MAV_TYPE_GCS,
    "rover": mav.MAV_TYPE_GROUND_ROVER,
    "boat": mav.MAV_TYPE_SURFACE_BOAT,
    "hexarotor": mav.MAV_TYPE_HEXAROTOR,
    "octorotor": mav.MAV_TYPE_OCTOROTOR,
    "onboard_controller": mav.MAV_TYPE_ONBOARD_CONTROLLER,
    "vtol": mav.MAV_TYPE_VTOL_RESERVED2,
}
"""MAV_TYPE by our names for it."""
TypeName = Literal[
    "fixed_wing", "quadrotor", "helicopter", "ground_station", "rover", "boat", "hexarotor", "octorotor",
    "onboard_controller", "vtol",
]  # fmt: skip
AUTOPILOTS = {
    "none": mav.MAV_AUTOPILOT_INVALID,
    "px4": mav.MAV_AUTOPILOT_PX4,
    "ardupilot": mav.MAV_AUTOPILOT_ARDUPILOTMEGA,
}
"""MAV_AUTOPILOT."""
AutopilotName = Literal["px4", "ardupilot", "none"]


SayingName = Literal["heartbeat", "mode", "state"]


def _heartbeat() -> list[SayingName]:
    return ["heartbeat"]


class OperatorModel(Once):
    """The operator asks the vehicle for something, from a ground station of his own."""

    kind: Literal["operator"]
    """the kind of event"""
    order: OrderName
    """what he asks for: a mode (hold, land, return, position, altitude, stabilized, mission, offboard, take_off), arm,
    disarm, kill (disarm in the air), terminate"""

    def event(self) -> Event:
        return events.Operator(self.when, Order(self.order))


class SticksModel(While):
    """The pilot has the sticks in his hands: without them the vehicle does not take a mode that needs them."""

    kind: Literal["sticks"]
    """the kind of event"""
    roll: Stick = 0.0
    """to the right, -1..1"""
    pitch: Stick = 0.0
    """forward, -1..1"""
    yaw: Stick = 0.0
    """to the right, -1..1"""
    throttle: Stick = 0.0
    """up, -1..1"""

    def event(self) -> Event:
        return events.Sticks(self.when, self.roll, self.pitch, self.yaw, self.throttle)


class StrangerModel(While):
    """Somebody else speaks to the companion: a second vehicle, a copy of ours, another companion."""

    kind: Literal["stranger"]
    """the kind of event"""
    system: Byte = 1
    """its MAVLink system, 1 to 255 (no unit); ours is 1"""
    component: Byte = 1
    """its MAVLink component, 1 to 255 (no unit); the autopilot's is 1"""
    type: TypeName = "quadrotor"
    """what it says it is: fixed_wing, quadrotor, rover, onboard_controller, ground_station, ..."""
    autopilot: AutopilotName = "px4"
    """its autopilot: px4, ardupilot, none"""
    says: Annotated[list[SayingName], Field(min_length=1)] = Field(default_factory=_heartbeat)
    """what it says: heartbeat (once a second), mode (CURRENT_MODE, ten times), state (ODOMETRY, fifty times)"""
    mode: ModeName = "hold"
    """the mode it says it flies"""
    armed: bool = True
    """whether it says it is armed"""
    position_m: Annotated[list[Metres], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0]
    )
    """where it says it stands still [north, east, down], in m"""
    port: Literal["own", "vehicle"] = "own"
    """where it sends from: a port of its own, or the vehicle's, as what the vehicle forwards"""

    def event(self) -> Event:
        x, y, z = self.position_m
        return events.Stranger(
            self.when, self.system, self.component, TYPES[self.type], AUTOPILOTS[self.autopilot],
            frozenset(map(Saying, self.says)), Order(self.mode), self.armed, (x, y, z), self.port == "own",
        )  # fmt: skip


class PortChangeModel(Once):
    """The vehicle sends to the companion from another port from then on, as a radio that dialled in again."""

    kind: Literal["port_change"]
    """the kind of event"""

    def event(self) -> Event:
        return events.PortChange(self.when)


ActorModel = OperatorModel | SticksModel | StrangerModel | PortChangeModel
