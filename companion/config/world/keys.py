"""The keys of a world file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator, model_validator

from companion.config.syntax.schema import Strict
from companion.config.world.event_keys import EventModel

Speed = Annotated[float, Field(ge=-50.0, le=50.0)]
Delay = Annotated[float, Field(ge=0.0, le=2.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Seconds = Annotated[float, Field(gt=0.0, le=1e4)]


def _three(value: Any) -> Any:
    return [value] * 3 if isinstance(value, int | float) and not isinstance(value, bool) else value


ONE_OR_THREE = {"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]}
T = TypeVar("T")
Three = Annotated[list[T], Field(min_length=3, max_length=3), BeforeValidator(_three), WithJsonSchema(ONE_OR_THREE)]
"""Three numbers, or one for all three."""
Metres = Three[Annotated[float, Field(ge=0.0, le=100.0)]]
Mps = Three[Annotated[float, Field(ge=0.0, le=50.0)]]
Mps2 = Three[Annotated[float, Field(ge=0.0, le=100.0)]]
Degrees = Three[Annotated[float, Field(ge=0.0, le=90.0)]]
Dps = Three[Annotated[float, Field(ge=0.0, le=1000.0)]]
Lengths = Three[Annotated[float, Field(ge=0.0, le=1e4)]]


def _zero() -> list[float]:
    return [0.0, 0.0, 0.0]


class HomeModel(Strict):
    """Where the local frame's origin lies."""

    latitude_deg: Annotated[float, Field(ge=-89.0, le=89.0)]
    """the latitude, in degrees"""
    longitude_deg: Annotated[float, Field(ge=-180.0, le=180.0)]
    """the longitude, in degrees"""
    altitude_m: Annotated[float, Field(ge=-500.0, le=9000.0)]
    """the altitude above mean sea level, in m"""


class GustsModel(Strict):
    """Gusts (Dryden): either as strong and large as told, or by the wind at 6 m and the height."""

    sigma_mps: Mps | None = None
    """the gusts' standard deviation, one number or [along the mean wind, across, down], in m/s"""
    length_m: Lengths | None = None
    """the gusts' length, one number or [along the mean wind, across, down], in m"""
    wind_at_6m_mps: Annotated[float, Field(gt=0.0, le=50.0)] | None = None
    """the wind at 6 m that MIL-F-8785C derives strength and length from: 7.7 light, 15 moderate, 23 severe, in m/s"""

    @field_validator("length_m")
    @classmethod
    def _has_a_length(cls, length: list[float] | None) -> list[float] | None:
        if length is not None and min(length) < 0.1:
            raise ValueError(f"{length} is too short; expected at least 0.1 m")
        return length

    @model_validator(mode="after")
    def _is_one_of_two(self) -> GustsModel:
        given = (self.sigma_mps is not None, self.length_m is not None, self.wind_at_6m_mps is not None)
        if given not in ((True, True, False), (False, False, True)):
            raise ValueError("expected sigma_mps and length_m, or wind_at_6m_mps alone")
        return self


class WayModel(Strict):
    """One way of the connection."""

    delay_s: Delay = 0.0
    """the delay, in s"""
    jitter_s: Delay = 0.0
    """how much longer a datagram may take at most, the order kept, in s"""
    loss: Share = 0.0
    """the share of datagrams that are lost, 0..1"""
    duplicated: Share = 0.0
    """the share of datagrams that come twice, 0..1"""
    reordered: Share = 0.0
    """the share of datagrams that come 20 ms late, behind those sent after them, 0..1"""
    duplicate_delay_s: Delay = 0.0
    """how long after the first the second of two comes, in s"""


class LinkModel(Strict):
    """The connection between vehicle and companion."""

    down: WayModel = Field(default_factory=WayModel)
    """vehicle to companion (delay_s, jitter_s, loss, duplicated, ...)"""
    up: WayModel = Field(default_factory=WayModel)
    """companion to vehicle (delay_s, jitter_s, loss, duplicated, ...)"""


class RotorsModel(Strict):
    """The paper's rotor dynamics, motor torque in, instead of a motor lag."""

    inertia_kgm2: Annotated[float, Field(gt=0.0, le=10.0)]
    """I_rz, the rotor's moment of inertia, in kg m^2"""
    thrust_factor: Annotated[float, Field(gt=0.0, le=1.0)]
    """gamma, thrust over the square of the rotor's speed, in N s^2"""


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
    rotor_drag_per_s: Annotated[float, Field(ge=0.0, le=5.0)] = 0.0
    """the linear drag over mass in the rotors' plane only, in 1/s"""
    quadratic_drag_per_m: Annotated[float, Field(ge=0.0, le=5.0)] = 0.0
    """the drag over mass that goes with the square of the airspeed, in 1/m"""
    thrust_scale: Annotated[float, Field(gt=0.1, le=3.0)] = 1.0
    """the true thrust of a command over the vehicle file's"""
    angular_drag_nms: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """the torque against the body rates, in N m per rad/s"""
    thrust_curve: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """the part of a rotor's thrust that goes with the command's square; THR_MDL_FAC stays 0, 0..1"""
    rate_gains: Annotated[list[Annotated[float, Field(gt=0.05, le=5.0)]], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [1.0, 1.0, 1.0]
    )
    """the autopilot's rate gains [roll, pitch, yaw] over those that its vehicle would usually be given"""
    rotors: RotorsModel | None = None
    """the paper's rotor dynamics instead of a motor lag (inertia_kgm2, thrust_factor)"""

    @field_validator("inertia_kgm2")
    @classmethod
    def _of_a_rigid_body(cls, inertia: list[float] | None) -> list[float] | None:
        if inertia is not None and 2.0 * max(inertia) > sum(inertia) * (1.0 + 1e-9):
            raise ValueError(f"{inertia} is no rigid body's; expected each moment to be at most the sum of the others")
        return inertia

    @model_validator(mode="after")
    def _rotors_have_one_lag(self) -> TruthModel:
        if self.rotors is not None and self.motor_lag_s is not None:
            raise ValueError("has motor_lag_s and rotors; expected one of them")
        return self


class BatteryModel(Strict):
    """A battery that sags: thrust goes with the square of its voltage."""

    capacity_mah: Annotated[float, Field(gt=0.0, le=1e6)]
    """what it holds when full, in mAh"""
    resistance_ohm: Annotated[float, Field(ge=0.0, le=2.0)]
    """its internal resistance, in ohm"""
    full_current_a: Annotated[float, Field(gt=0.0, le=2000.0)]
    """the current at full thrust of all rotors, in A; it goes with thrust to the power of 1.5"""
    idle_current_a: Annotated[float, Field(ge=0.0, le=100.0)] = 0.5
    """the current of everything but the motors, in A"""
    charge: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0
    """how full it is at the start, 0..1"""
    full_v: Annotated[float, Field(gt=0.0, le=1000.0)] = 16.2
    """the voltage when full and not loaded, in V"""
    empty_v: Annotated[float, Field(gt=0.0, le=1000.0)] = 14.4
    """the voltage when empty and not loaded, in V"""

    @model_validator(mode="after")
    def _sags(self) -> BatteryModel:
        if self.empty_v > self.full_v:
            raise ValueError(f"is empty at {self.empty_v:g} V and full at {self.full_v:g} V; expected empty below full")
        return self


class NoiseModel(Strict):
    """What the errors of any quantity have."""

    wander_s: Seconds = 1.0
    """the wander's time constant, in s"""
    smooth: bool = False
    """whether the wander has no corners (two lags of that time in a row)"""


class PositionNoiseModel(NoiseModel):
    """The position's errors."""

    white_m: Metres = Field(default_factory=_zero)
    """standard deviation that is new at every step, one number or [north, east, down], in m"""
    wander_m: Metres = Field(default_factory=_zero)
    """standard deviation of a slow wander (first-order Gauss-Markov), one number or [north, east, down], in m"""


class VelocityNoiseModel(NoiseModel):
    """The velocity's errors."""

    white_mps: Mps = Field(default_factory=_zero)
    """standard deviation that is new at every step, one number or [north, east, down], in m/s"""
    wander_mps: Mps = Field(default_factory=_zero)
    """standard deviation of a slow wander (first-order Gauss-Markov), one number or [north, east, down], in m/s"""


class AttitudeNoiseModel(NoiseModel):
    """The attitude's errors."""

    white_deg: Degrees = Field(default_factory=_zero)
    """standard deviation that is new at every step, one number or [roll, pitch, yaw], in degrees"""
    wander_deg: Degrees = Field(default_factory=_zero)
    """standard deviation of a slow wander (first-order Gauss-Markov), one number or [roll, pitch, yaw], in degrees"""
    start_deg: Degrees | None = None
    """standard deviation of that wander at the start, as wander_deg; as there where absent, in degrees"""
    start_s: Seconds = 10.0
    """the time constant in which it comes from there to wander_deg, in s"""
    bias_deg: Degrees = Field(default_factory=_zero)
    """standard deviation of an error that stays, drawn once, one number or [roll, pitch, yaw], in degrees"""
    frame: Literal["body", "world"] = "body"
    """what it turns about: the body's axes, or north, east and down as an EKF's tilt error does (body, world)"""


class GyroNoiseModel(NoiseModel):
    """The body rates' errors."""

    white_dps: Dps = Field(default_factory=_zero)
    """standard deviation that is new at every step, one number or [roll, pitch, yaw], in degrees per second"""
    wander_dps: Dps = Field(default_factory=_zero)
    """standard deviation of a slow wander (first-order Gauss-Markov), one number or [roll, pitch, yaw], in deg/s"""


class AccelerometerNoiseModel(NoiseModel):
    """The accelerometer's errors, which HIGHRES_IMU and SCALED_IMU show."""

    white_mps2: Mps2 = Field(default_factory=_zero)
    """standard deviation that is new at every step, one number or [forward, right, down], in m/s^2"""
    wander_mps2: Mps2 = Field(default_factory=_zero)
    """standard deviation of a slow wander (first-order Gauss-Markov), one number or [forward, right, down], in m/s^2"""


class DriftModel(Strict):
    """A smooth wander of the position that the velocity does not show."""

    speed_mps: Mps = Field(default_factory=_zero)
    """standard deviation of velocity minus the position's derivative, one number or [north, east, down], in m/s"""
    time_s: Seconds = 1.0
    """its time constant, in s; the position wanders by speed_mps times time_s"""


class EstimateModel(Strict):
    """How wrong the vehicle's idea of its state is."""

    position: PositionNoiseModel = Field(default_factory=PositionNoiseModel)
    """the position's errors (white_m, wander_m, wander_s, smooth)"""
    velocity: VelocityNoiseModel = Field(default_factory=VelocityNoiseModel)
    """the velocity's errors (white_mps, wander_mps, wander_s, smooth)"""
    attitude: AttitudeNoiseModel = Field(default_factory=AttitudeNoiseModel)
    """the attitude's errors (white_deg, wander_deg, wander_s, smooth, start_deg, start_s, bias_deg, frame)"""
    gyro: GyroNoiseModel = Field(default_factory=GyroNoiseModel)
    """the body rates' errors (white_dps, wander_dps, wander_s, smooth)"""
    drift: DriftModel = Field(default_factory=DriftModel)
    """a wander of the position that the velocity does not show (speed_mps, time_s)"""
    accelerometer: AccelerometerNoiseModel = Field(default_factory=AccelerometerNoiseModel)
    """the accelerometer's errors (white_mps2, wander_mps2, wander_s, smooth)"""


class WorldModel(Strict):
    """A world file."""

    name: str
    """the world's name"""
    wind_mps: Annotated[list[Speed], Field(min_length=3, max_length=3)] = Field(default_factory=_zero)
    """the mean velocity of the air over the ground [north, east, down], in m/s"""
    gusts: GustsModel | None = None
    """gusts on top of it (sigma_mps and length_m, or wind_at_6m_mps)"""
    home: HomeModel | None = None
    """where the local frame's origin lies (latitude_deg, longitude_deg, altitude_m); default the home of PX4's SIH"""
    link: LinkModel = Field(default_factory=LinkModel)
    """the connection between vehicle and companion (down, up)"""
    truth: TruthModel = Field(default_factory=TruthModel)
    """the machine as it really is, where it differs from its vehicle file (mass_kg, drag_per_s, ...)"""
    battery: BatteryModel | None = None
    """a battery that sags (capacity_mah, resistance_ohm, full_current_a, ...); default one that never does"""
    estimate: EstimateModel = Field(default_factory=EstimateModel)
    """how wrong the vehicle's idea of its state is (position, velocity, attitude, gyro, drift, accelerometer)"""
    events: list[EventModel] = Field(default_factory=list)
    """what happens at a time (kind push, hold, link_cut, operator, ...)"""
