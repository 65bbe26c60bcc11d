"""The machine as it really is, where it differs from its vehicle file; and its battery."""

from __future__ import annotations

from dataclasses import dataclass

from companion.frames import Vec3


@dataclass(frozen=True, slots=True)
class RotorDynamics:
    """The paper's rotor (section II), with the motor's torque as its input: I_rz Omega' = -b Omega^2 + tau,
    f = gamma Omega^2, b / gamma being the vehicle file's torque per thrust.

    ``inertia``: I_rz, kg m^2; ``thrust_factor``: gamma, N s^2. The frame feels tau, not b Omega^2.
    """

    inertia: float
    thrust_factor: float


@dataclass(frozen=True, slots=True)
class Deviations:
    """The machine as it really is, where it differs from its vehicle file. None: as the file says.

    From ``angular_drag`` on: what vehicle files do not know.
    """

    mass: float | None = None  # kg
    inertia: Vec3 | None = None  # kg m^2, the diagonal of J
    motor_lag: float | None = None  # s
    drag: float | None = None  # 1/s, linear, over mass
    thrust_scale: float = 1.0  # true over stated thrust
    angular_drag: float = 0.0  # N m s, torque against the body rates
    rotor_drag: float = 0.0  # 1/s, linear, over mass, in the rotors' plane only
    quadratic_drag: float = 0.0  # 1/m, over mass, against the airspeed
    thrust_curve: float = 0.0  # the part of the thrust that goes with the command's square (what THR_MDL_FAC should be)
    rate_gains: Vec3 = (
        1.0,
        1.0,
        1.0,
    )  # the autopilot's rate gains (roll, pitch, yaw) over the usual ones
    rotors: RotorDynamics | None = None  # in the place of the motor lag


@dataclass(frozen=True, slots=True)
class Battery:
    """A battery whose voltage falls with its charge and with the current; thrust goes with the voltage's square."""

    capacity: float  # C
    resistance: float  # ohm
    full_current: float  # A at full thrust of all rotors; it goes with thrust to the power of 1.5
    idle_current: float = 0.5  # A
    charge: float = 1.0  # 1 full
    full: float = 16.2  # V at no current
    empty: float = 14.4  # V at no current
