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

    ``mass`` kg, ``inertia`` kg m^2, ``motor_lag`` s, ``drag`` 1/s, ``thrust_scale`` true over stated thrust. What
    vehicle files do not know: ``angular_drag`` N m s (torque against the body rates), ``rotor_drag`` 1/s (linear, over
    mass, in the rotors' plane only), ``quadratic_drag`` 1/m (over mass, against the airspeed), ``thrust_curve`` the
    part of the thrust that goes with the command's square (what THR_MDL_FAC should be), ``rate_gains`` the autopilot's
    rate gains about roll, pitch, yaw over those it would usually have, ``rotors`` in the place of the motor lag.
    """

    mass: float | None = None
    inertia: Vec3 | None = None
    motor_lag: float | None = None
    drag: float | None = None
    thrust_scale: float = 1.0
    angular_drag: float = 0.0
    rotor_drag: float = 0.0
    quadratic_drag: float = 0.0
    thrust_curve: float = 0.0
    rate_gains: Vec3 = (1.0, 1.0, 1.0)
    rotors: RotorDynamics | None = None


@dataclass(frozen=True, slots=True)
class Battery:
    """A battery whose voltage falls with its charge and with the current; thrust goes with the voltage's square.

    ``capacity`` C, ``resistance`` ohm, ``full_current`` A at full thrust of all rotors (it goes with thrust to the
    power of 1.5), ``idle_current`` A, ``charge`` 1 full, ``full`` and ``empty`` V at no current.
    """

    capacity: float
    resistance: float
    full_current: float
    idle_current: float = 0.5
    charge: float = 1.0
    full: float = 16.2
    empty: float = 14.4
