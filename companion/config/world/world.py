"""World files: the air, the link and the true machine of a simulated flight; and how a vehicle starts in it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field, field_validator

from companion.config.syntax.document import Document, parse, scalar
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.syntax.file_lookup import find, read
from companion.config.syntax.schema import Strict, validate
from companion.config.world.keys import (
    AttitudeNoiseModel,
    BatteryModel,
    EstimateModel,
    GustsModel,
    HomeModel,
    NoiseModel,
    TruthModel,
    WayModel,
    WorldModel,
)
from companion.frames import Vec3, normalised
from companion.world import Home, Start, World
from companion.world.air import DrydenGusts, Gusts
from companion.world.estimate import Drift, Errors, Noise
from companion.world.link import Link, Way
from companion.world.machine import Battery, Deviations, RotorDynamics

COULOMB_PER_MAH = 3.6
"""C in one mAh."""
Three = Annotated[list[Annotated[float, Field(ge=-1e6, le=1e6)]], Field(min_length=3, max_length=3)]


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


def home_from(text: str, option: str) -> Home:
    """The home an option gives: latitude, longitude, metres above sea level. ConfigError with every fault."""
    names = list(HomeModel.model_fields)
    values = [scalar(part.strip()) for part in text.split(",")]
    if len(values) != len(names):
        raise ConfigError([Fault(option, 0, "", f"{text!r}; expected LATITUDE,LONGITUDE,METRES above sea level")])
    home = validate(Document(option, dict(zip(names, values, strict=True)), {(): 0}), HomeModel)
    return Home(home.latitude_deg, home.longitude_deg, home.altitude_m)


def load_world(name: str) -> World:
    """The world of a name in configs/worlds or a path. ConfigError with every fault."""
    path = find(name, "worlds")
    return world_from(parse(read(path), str(path)))


def world_from(document: Document) -> World:
    """The world a document describes. ConfigError with every fault."""
    model = validate(document, WorldModel)
    home = model.home
    return World(
        name=model.name,
        wind_n=_vector(model.wind_mps),
        gusts=None if model.gusts is None else _gusts(model.gusts),
        home=Home() if home is None else Home(home.latitude_deg, home.longitude_deg, home.altitude_m),
        link=Link(_way(model.link.down), _way(model.link.up)),
        truth=_truth(model.truth),
        battery=None if model.battery is None else _battery(model.battery),
        estimate=_estimate(model.estimate),
        events=tuple(each.event() for each in model.events),
    )


def _vector(three: Sequence[float], unit: float = 1.0) -> Vec3:
    x, y, z = three
    return (x * unit, y * unit, z * unit)


def _gusts(model: GustsModel) -> Gusts | DrydenGusts:
    if model.wind_at_6m_mps is not None:
        return DrydenGusts(model.wind_at_6m_mps)
    assert model.sigma_mps is not None and model.length_m is not None
    return Gusts(_vector(model.sigma_mps), _vector(model.length_m))


def _way(model: WayModel) -> Way:
    return Way(
        model.delay_s, model.jitter_s, model.loss, model.duplicated, model.reordered, model.duplicate_delay_s
    )  # fmt: skip


def _truth(model: TruthModel) -> Deviations:
    rotors = model.rotors
    return Deviations(
        mass=model.mass_kg,
        inertia=None if model.inertia_kgm2 is None else _vector(model.inertia_kgm2),
        motor_lag=model.motor_lag_s,
        drag=model.drag_per_s,
        thrust_scale=model.thrust_scale,
        angular_drag=model.angular_drag_nms,
        rotor_drag=model.rotor_drag_per_s,
        quadratic_drag=model.quadratic_drag_per_m,
        thrust_curve=model.thrust_curve,
        rate_gains=_vector(model.rate_gains),
        rotors=None if rotors is None else RotorDynamics(rotors.inertia_kgm2, rotors.thrust_factor),
    )


def _battery(model: BatteryModel) -> Battery:
    return Battery(
        capacity=model.capacity_mah * COULOMB_PER_MAH,
        resistance=model.resistance_ohm,
        full_current=model.full_current_a,
        idle_current=model.idle_current_a,
        charge=model.charge,
        full=model.full_v,
        empty=model.empty_v,
    )


def _estimate(model: EstimateModel) -> Errors:
    position, velocity, attitude, gyro = model.position, model.velocity, model.attitude, model.gyro
    accelerometer = model.accelerometer
    return Errors(
        _noise(position.white_m, position.wander_m, position),
        _noise(velocity.white_mps, velocity.wander_mps, velocity),
        _attitude_noise(attitude),
        _noise(gyro.white_dps, gyro.wander_dps, gyro, math.radians(1.0)),
        Drift(_vector(model.drift.speed_mps), model.drift.time_s),
        _noise(accelerometer.white_mps2, accelerometer.wander_mps2, accelerometer),
        attitude.frame == "world",
    )


def _attitude_noise(model: AttitudeNoiseModel) -> Noise:
    degree = math.radians(1.0)
    return dataclasses.replace(
        _noise(model.white_deg, model.wander_deg, model, degree),
        start=None if model.start_deg is None else _vector(model.start_deg, degree),
        start_time=model.start_s,
        bias=_vector(model.bias_deg, degree),
    )


def _noise(white: Sequence[float], wander: Sequence[float], model: NoiseModel, unit: float = 1.0) -> Noise:
    return Noise(_vector(white, unit), _vector(wander, unit), model.wander_s, model.smooth)
