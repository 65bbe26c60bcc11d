"""World files: the air, the link and the true machine of a simulated flight; and how a vehicle starts in it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from companion.config.document import Document, parse
from companion.config.places import find, read
from companion.config.schema import Strict, validate
from companion.frames import normalised
from companion.world import Deviations, Home, Link, Start, World

Speed = Annotated[float, Field(ge=-50.0, le=50.0)]
Delay = Annotated[float, Field(ge=0.0, le=2.0)]
Three = Annotated[list[Annotated[float, Field(ge=-1e6, le=1e6)]], Field(min_length=3, max_length=3)]


class HomeModel(Strict):
    """Where the local frame's origin lies."""

    latitude_deg: Annotated[float, Field(ge=-89.0, le=89.0)]
    """the latitude, in degrees"""
    longitude_deg: Annotated[float, Field(ge=-180.0, le=180.0)]
    """the longitude, in degrees"""
    altitude_m: Annotated[float, Field(ge=-500.0, le=9000.0)]
    """the altitude above mean sea level, in m"""


class LinkModel(Strict):
    """The connection between vehicle and companion."""

    delay_down_s: Delay = 0.0
    """the delay from vehicle to companion, in s"""
    delay_up_s: Delay = 0.0
    """the delay from companion to vehicle, in s"""


class TruthModel(Strict):
    """The machine as it really is, where it differs from its vehicle file."""

    mass_kg: Annotated[float, Field(gt=0.0, le=500.0)] | None = None
    """the true mass, in kg"""
    inertia_kgm2: (
        Annotated[list[Annotated[float, Field(gt=0.0, le=1000.0)]], Field(min_length=3, max_length=3)] | None
    ) = None
    """the true moments of inertia [roll, pitch, yaw], in kg m^2"""
    motor_lag_s: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """the true time constant of a motor's thrust, in s"""
    drag_per_s: Annotated[float, Field(ge=0.0, le=5.0)] | None = None
    """the true linear drag over mass, in 1/s"""
    thrust_scale: Annotated[float, Field(gt=0.1, le=3.0)] = 1.0
    """the true thrust of a command over the vehicle file's"""
    angular_drag_nms: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """the torque against the body rates, in N m per rad/s"""

    @field_validator("inertia_kgm2")
    @classmethod
    def _of_a_rigid_body(cls, inertia: list[float] | None) -> list[float] | None:
        if inertia is not None and 2.0 * max(inertia) > sum(inertia) * (1.0 + 1e-9):
            raise ValueError(f"{inertia} is no rigid body's; expected each moment to be at most the sum of the others")
        return inertia


class WorldModel(Strict):
    """A world file."""

    name: str
    """the world's name"""
    wind_mps: Annotated[list[Speed], Field(min_length=3, max_length=3)] = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """the velocity of the air over the ground [north, east, down], in m/s"""
    home: HomeModel | None = None
    """where the local frame's origin lies (latitude_deg, longitude_deg, altitude_m); default the home of PX4's SIH"""
    link: LinkModel = Field(default_factory=LinkModel)
    """the connection between vehicle and companion (delay_down_s, delay_up_s)"""
    truth: TruthModel = Field(default_factory=TruthModel)
    """the machine as it really is, where it differs from its vehicle file (mass_kg, drag_per_s, ...)"""


class StartModel(Strict):
    """A start in the air."""

    position_n: Three
    """where [north, east, down] in the local frame, in m"""
    velocity_n: Three = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """how fast [north, east, down], in m/s"""
    q_nb: Annotated[list[float], Field(min_length=4, max_length=4)] = Field(
        default_factory=lambda: [1.0, 0.0, 0.0, 0.0]
    )
    """the attitude as a quaternion [w, x, y, z], body to world"""
    rates_b: Three = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """the body rates [roll, pitch, yaw], in rad/s"""
    held: bool = False
    """whether nothing moves until the first setpoint in offboard"""

    @field_validator("q_nb")
    @classmethod
    def _is_a_rotation(cls, q: list[float]) -> list[float]:
        norm = sum(x * x for x in q) ** 0.5
        if not 0.99 < norm < 1.01:
            raise ValueError(f"{q} has length {norm:.4g}; expected a unit quaternion [w, x, y, z]")
        return q


def start_from(document: Document) -> Start:
    """The start a document describes. ConfigError with every fault."""
    model = validate(document, StartModel)
    (px, py, pz), (vx, vy, vz), (wx, wy, wz) = model.position_n, model.velocity_n, model.rates_b
    w, x, y, z = model.q_nb
    return Start((px, py, pz), (vx, vy, vz), normalised((w, x, y, z)), (wx, wy, wz), model.held)


def load_world(name: str) -> World:
    """The world of a name in configs/worlds or a path. ConfigError with every fault."""
    path = find(name, "worlds")
    return world_from(parse(read(path), str(path)))


def world_from(document: Document) -> World:
    """The world a document describes. ConfigError with every fault."""
    model = validate(document, WorldModel)
    north, east, down = model.wind_mps
    home, truth = model.home, model.truth
    inertia = None
    if truth.inertia_kgm2 is not None:
        x, y, z = truth.inertia_kgm2
        inertia = (x, y, z)
    return World(
        name=model.name,
        wind_n=(north, east, down),
        home=Home() if home is None else Home(home.latitude_deg, home.longitude_deg, home.altitude_m),
        link=Link(model.link.delay_down_s, model.link.delay_up_s),
        truth=Deviations(
            mass=truth.mass_kg,
            inertia=inertia,
            motor_lag=truth.motor_lag_s,
            drag=truth.drag_per_s,
            thrust_scale=truth.thrust_scale,
            angular_drag=truth.angular_drag_nms,
        ),
    )
