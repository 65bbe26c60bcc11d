"""Vehicle files: a quadrotor in the units of a data sheet."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, field_validator

from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.file_lookup import find, read
from companion.config.syntax.schema import Strict, validate
from companion.vehicle import GRAVITY, Limits, MotorInterface, Rotor, Spin, Vehicle

Rate = Annotated[float, Field(gt=0.0, le=2000.0)]
Metres = Annotated[float, Field(ge=-5.0, le=5.0)]


class RotorModel(Strict):
    """One rotor."""

    position_m: Annotated[list[Metres], Field(min_length=3, max_length=3)]
    """the rotor's place [forward, right, down] from the centre of mass, in m"""
    spin: Literal["ccw", "cw"]
    """the rotor's sense of turning seen from above, ccw or cw"""
    thrust_max_n: Annotated[float, Field(gt=0.0, le=5000.0)]
    """the thrust at command 1, in N"""
    torque_per_thrust_m: Annotated[float, Field(gt=0.0, lt=1.0)]
    """reaction torque over thrust, in m (about 0.01 to 0.03)"""
    command: Annotated[list[float], Field(min_length=2, max_length=2)] = Field(default_factory=lambda: [0.0, 1.0])
    """the range of motor commands [lowest, highest], no unit, thrust being command times thrust_max_n"""

    @field_validator("command")
    @classmethod
    def _is_a_range(cls, command: list[float]) -> list[float]:
        low, high = command
        if not (-1.0 <= low < high <= 1.0 and high > 0.0):
            raise ValueError(f"{command} is no range of commands; expected lowest < highest, both within -1..1")
        return command


class LimitsModel(Strict):
    """What the vehicle may be asked for."""

    tilt_deg: Annotated[float, Field(gt=0.0, le=80.0)] = 45.0
    """the largest tilt the path may ask for, in degrees"""
    body_rate_dps: Annotated[list[Rate], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [220.0, 220.0, 85.0]
    )
    """the largest body rates [roll, pitch, yaw], in degrees per second"""
    speed: Annotated[float, Field(gt=0.0, le=100.0)] = 12.0
    """the largest speed, in m/s"""
    failure_detector_deg: Annotated[float, Field(gt=10.0, le=180.0)] = 60.0
    """the tilt at which the autopilot ends the flight (FD_FAIL_R, FD_FAIL_P), in degrees; paths stay 10 under it"""

    @field_validator("tilt_deg")
    @classmethod
    def _tilt_in_degrees(cls, tilt: float) -> float:
        if tilt < 2.0:
            raise ValueError(f"{tilt:g} is under two degrees; expected degrees, is this in radians?")
        return tilt

    @field_validator("body_rate_dps")
    @classmethod
    def _rates_in_degrees(cls, rates: list[float]) -> list[float]:
        if max(rates) < 10.0:
            raise ValueError(f"{rates} is very slow; expected degrees per second, is this in rad/s?")
        return rates


class VehicleModel(Strict):
    """A vehicle file."""

    name: str
    """the vehicle's name"""
    mass_kg: Annotated[float, Field(gt=0.0, le=500.0)]
    """the take-off mass in kg"""
    inertia_kgm2: Annotated[list[Annotated[float, Field(gt=0.0, le=1000.0)]], Field(min_length=3, max_length=3)]
    """the moments of inertia [roll, pitch, yaw], in kg m^2"""
    gravity: Annotated[float, Field(gt=0.0, le=30.0)] = GRAVITY
    """the acceleration of gravity, in m/s^2"""
    rotors: Annotated[list[RotorModel], Field(min_length=4, max_length=4)]
    """the four rotors in the autopilot's motor order"""
    motor_lag_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """the time constant of a motor's thrust, in s"""
    drag_per_s: Annotated[float, Field(ge=0.0, le=5.0)] = 0.0
    """linear drag over mass, in 1/s"""
    hover_thrust: Annotated[float, Field(gt=0.0, lt=1.0)] | Literal["auto"] = "auto"
    """the normalised thrust that hovers, 0..1, or auto to learn it"""
    rate_loop_lag_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.06
    """how late the autopilot's rate loop follows, in s"""
    link_delay_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.01
    """the delay of the link, state to setpoint, in s"""
    state_rate_hz: Annotated[float, Field(ge=20.0, le=2000.0)] = 250.0
    """how often the vehicle is asked for its state, in Hz"""
    motors: Literal["px4", "direct"] = "px4"
    """px4 where the autopilot mixes, direct where it takes motor commands"""
    limits: LimitsModel | Literal["none"] = Field(default_factory=LimitsModel)
    """what the vehicle may be asked for (tilt_deg, body_rate_dps, speed), or none"""

    @field_validator("inertia_kgm2")
    @classmethod
    def _of_a_rigid_body(cls, inertia: list[float]) -> list[float]:
        if 2.0 * max(inertia) > sum(inertia) * (1.0 + 1e-9):
            raise ValueError(f"{inertia} is no rigid body's; expected each moment to be at most the sum of the others")
        return inertia


LIFT_MAX = 20.0
"""Thrust over weight that no vehicle has: from here on a unit is suspected (engineering choice)."""
HOVER_APART = 1.5
"""How far a hover thrust may lie from what mass and rotors make, up or down (engineering choice): a battery that sags
and a thrust curve between linear and quadratic."""
LAG_APART = 2.0
"""Motor lag over rate loop lag that no vehicle has that flies: a rate loop around motors that slow swings (its damping
is 0.35). Simulated: told 2.1 for a true 0.7, a vehicle turns over in its first second."""
MOTOR_LAG_USUAL = 0.1
"""s, to which a motor lag is believed whatever the rate loop (engineering choice)."""
GYRATION_MIN, GYRATION_MAX = 0.03, 15.0
"""Radii of gyration that a machine may have, in units of its longest arm."""


def load_vehicle(name: str) -> Vehicle:
    """The vehicle of a name in configs/vehicles or a path. ConfigError with every fault."""
    path = find(name, "vehicles")
    return vehicle_from(parse(read(path), str(path)))


def vehicle_from(document: Document) -> Vehicle:
    """The vehicle a document describes. ConfigError with every fault."""
    model = validate(document, VehicleModel)
    contradiction = _contradiction(model)
    if contradiction is not None:
        raise ConfigError([document.fault(*contradiction)])
    arm = max(math.hypot(*rotor.position_m) for rotor in model.rotors)
    for i, inertia in enumerate(model.inertia_kgm2):
        # the radius of a ring of the vehicle's mass that has this inertia; the paper's own machine is at 8 arms
        radius = math.sqrt(inertia / model.mass_kg)
        if not GYRATION_MIN * arm < radius < GYRATION_MAX * arm:
            message = (
                f"{inertia:g} is that of {model.mass_kg:g} kg at {radius:.2g} m from the axis, and rotors at {arm:.2g}"
                "; expected kg m^2, is this in another unit?"
            )
            raise ConfigError([document.fault(("inertia_kgm2", i), message)])
    limits = None
    if isinstance(model.limits, LimitsModel):
        roll, pitch, yaw = map(math.radians, model.limits.body_rate_dps)
        limits = Limits(
            tilt=math.radians(model.limits.tilt_deg),
            body_rates=(roll, pitch, yaw),
            speed=model.limits.speed,
            failure_detector=math.radians(model.limits.failure_detector_deg),
        )
    x, y, z = model.inertia_kgm2
    return Vehicle(
        name=model.name,
        mass=model.mass_kg,
        inertia=(x, y, z),
        gravity=model.gravity,
        rotors=tuple(_rotor(rotor) for rotor in model.rotors),
        motor_lag=model.motor_lag_s,
        drag=model.drag_per_s,
        hover_thrust=None if model.hover_thrust == "auto" else model.hover_thrust,
        rate_loop_lag=model.rate_loop_lag_s,
        dead_time=model.link_delay_s,
        motors=MotorInterface(model.motors),
        state_rate=model.state_rate_hz,
        limits=limits,
    )


def _contradiction(model: VehicleModel) -> tuple[tuple[str, ...], str] | None:
    """Where mass, thrust and hover thrust, or lags, cannot all be true: the key, and the words."""
    thrust = sum(rotor.thrust_max_n * max(rotor.command) for rotor in model.rotors)
    weight = model.mass_kg * model.gravity
    if thrust < 1.1 * weight:
        message = f"weighs {weight:.4g} N but the rotors lift {thrust:.4g} N at most; expected a tenth to spare"
        if thrust * GRAVITY >= 1.1 * weight:
            message += " (thrust_max_n in kgf? 1 kgf is 9.81 N)"
        return ("mass_kg",), message
    grams = thrust * GRAVITY / 1000.0
    if thrust > LIFT_MAX * weight and 1.1 * weight <= grams <= LIFT_MAX * weight:
        each = model.rotors[0].thrust_max_n
        message = f"the rotors lift {thrust / weight:.0f} times the weight; expected newtons"
        return ("rotors",), f"{message} (thrust_max_n in gram-force? {each:g} gf is {each * GRAVITY / 1000.0:.3g} N)"
    hover = weight / thrust
    if model.hover_thrust != "auto" and model.limits != "none":
        least, most = hover / HOVER_APART, HOVER_APART * math.sqrt(hover)
        if not least <= model.hover_thrust <= most:
            return ("hover_thrust",), (
                f"{model.hover_thrust:g} contradicts mass and rotors, which hover at {hover:.2f} "
                f"({math.sqrt(hover):.2f} where thrust goes with the command's square); expected auto, or one of them"
            )
    most = max(LAG_APART * model.rate_loop_lag_s, MOTOR_LAG_USUAL)
    if model.motors == "px4" and model.limits != "none" and model.motor_lag_s > most:
        return ("motor_lag_s",), (
            f"{model.motor_lag_s:g} contradicts rate_loop_lag_s, {model.rate_loop_lag_s:g}: a rate loop around motors "
            f"that slow would swing; expected {most:g} at most, usual are 0.015 to 0.06"
        )
    return None


def _rotor(model: RotorModel) -> Rotor:
    x, y, z = model.position_m
    low, high = model.command
    return Rotor((x, y, z), Spin(model.spin), model.thrust_max_n, model.torque_per_thrust_m, (low, high))
