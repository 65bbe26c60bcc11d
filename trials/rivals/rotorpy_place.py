"""RotorPy's simulator, a second opinion on the world: its Hummingbird with its own aerodynamics.

Its world is x east-like, y, z up and its body x forward, y left, z up; ours are NED and FRD. Both turn into each other
by half a turn about x, diag(1, -1, -1).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rotorpy.controllers.quadrotor_control import SE3Control
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor

from companion.frames import Vec3, euler_from_rotation, rotation_matrix, tilt
from companion.pilot.targets import smooth_start
from companion.plan import Plan
from companion.steering.steering import Along
from companion.vehicle import Limits, RateSetpoint, Rotor, Spin, Vehicle, VehicleState
from trials.rivals.course import Course, Moment
from trials.rivals.figures import Sample

RATE_GAIN = 40.0
"""1/s, the gain of the rate loop that stands for an autopilot's (RotorPy's default of 1 is no rate loop)."""
HOVER = 0.4
"""What the Hummingbird is told to hover at, as share of full thrust: full thrust is then its weight over this."""
CONTROL_PERIOD = 0.01
GRAVITY = 9.81


def turned(x: Any) -> Vec3:
    """A vector from one frame into the other."""
    return (float(x[0]), -float(x[1]), -float(x[2]))


def hummingbird(drag: float = 0.0, mass_error: float = 0.0, dead_time: float = 0.0) -> Vehicle:
    """What the companion is told of it. ``drag`` 1/s; ``mass_error``: a share of the mass."""
    mass = quad_params["mass"]
    lift = mass * GRAVITY / HOVER / 4.0
    arm = 0.17 * math.sqrt(0.5)
    spots = (((arm, arm), Spin.CCW), ((-arm, -arm), Spin.CCW), ((arm, -arm), Spin.CW), ((-arm, arm), Spin.CW))
    return Vehicle(
        name="hummingbird",
        mass=mass * (1.0 + mass_error),
        inertia=(quad_params["Ixx"], quad_params["Iyy"], quad_params["Izz"]),
        gravity=GRAVITY,
        rotors=tuple(
            Rotor((x, y, 0.0), spin, lift, quad_params["k_m"] / quad_params["k_eta"]) for (x, y), spin in spots
        ),
        motor_lag=quad_params["tau_m"],
        drag=drag,
        hover_thrust=HOVER * (1.0 + mass_error),
        rate_loop_lag=1.0 / RATE_GAIN,
        dead_time=dead_time,
        state_rate=1.0 / CONTROL_PERIOD,
        limits=Limits(tilt=math.radians(70.0), failure_detector=math.radians(85.0)),
    )


@dataclass
class Place:
    """RotorPy's Multirotor in a steady wind (m/s, NED). ``held``: from and to, s, in which it is kept still."""

    wind_n: Vec3 = (0.0, 0.0, 0.0)
    held: tuple[float, float] | None = None
    abstraction: str = "cmd_ctbr"
    t: float = 0.0
    track: list[Sample] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._machine = Multirotor(
            {**quad_params, "k_w": RATE_GAIN},
            control_abstraction=self.abstraction,
            integrator_kwargs={"method": "RK45"},
        )
        self._state: dict[str, Any] = {}

    def put(self, moment: Moment) -> None:
        """At rest and level at the beginning of a course."""
        speed = math.sqrt(quad_params["mass"] * GRAVITY / 4.0 / quad_params["k_eta"])
        self._state = {
            "x": np.array(turned(moment.p_n)),
            "v": np.zeros(3),
            "q": np.array([0.0, 0.0, 0.0, 1.0]),
            "w": np.zeros(3),
            "wind": np.array(turned(self.wind_n)),
            "rotor_speeds": np.full(4, speed),
        }
        self._seen()

    @property
    def raw(self) -> dict[str, Any]:
        """RotorPy's own state."""
        return self._state

    @property
    def state(self) -> VehicleState:
        """As an autopilot would report it."""
        i, j, k, w = (float(value) for value in self._state["q"])
        return VehicleState(
            self.t, turned(self._state["x"]), turned(self._state["v"]), (w, i, -j, -k), turned(self._state["w"])
        )

    def step(self, control: dict[str, Any], dt: float) -> None:
        """``dt`` s later, under one of RotorPy's controls."""
        kept = self._state["x"].copy(), self._state["q"].copy()
        self._state = self._machine.step(self._state, control, dt)
        self._state["wind"] = np.array(turned(self.wind_n))
        self.t += dt
        if self.held is not None and self.held[0] <= self.t < self.held[1]:
            self._state["x"], self._state["q"] = kept
            self._state["v"], self._state["w"] = np.zeros(3), np.zeros(3)
        self._seen()

    def _seen(self) -> None:
        state = self.state
        r_nb = rotation_matrix(state.q_nb)
        self.track.append(Sample(self.t, state.p_n, state.v_n, euler_from_rotation(r_nb)[0], tilt(r_nb)))


def control_of(setpoint: RateSetpoint) -> dict[str, Any]:
    """Our rates and thrust as RotorPy takes them."""
    full = quad_params["mass"] * GRAVITY / HOVER
    return {"cmd_thrust": setpoint.thrust * full, "cmd_w": np.array(turned(setpoint.rates_b))}


def fly_its_own(course: Course, place: Place, seconds: float) -> list[Sample]:
    """RotorPy's stock SE3Control on the timetable of ``course``, without any delay."""
    controller = SE3Control(quad_params)
    place.put(course.at(0.0))
    while place.t < seconds:
        moment = course.at(place.t)
        flat = {
            "x": np.array(turned(moment.p_n)),
            "x_dot": np.array(turned(moment.v_n)),
            "x_ddot": np.array(turned(moment.a_n)),
            "x_dddot": np.array(turned(moment.j_n)),
            "yaw": 0.0,
            "yaw_dot": 0.0,
        }
        place.step(controller.update(place.t, place.raw, flat), CONTROL_PERIOD)
    return place.track


class Delayed:
    """What was sent, and when it acts: a link with a delay (s)."""

    def __init__(self, delay: float, first: dict[str, Any]) -> None:
        self._delay = delay
        self._sent: deque[tuple[float, dict[str, Any]]] = deque()
        self._acting = first

    def send(self, t: float, control: dict[str, Any]) -> None:
        """Send at ``t``."""
        self._sent.append((t + self._delay, control))

    def at(self, t: float) -> dict[str, Any]:
        """What acts at ``t``."""
        while self._sent and self._sent[0][0] <= t + 1e-9:
            self._acting = self._sent.popleft()[1]
        return self._acting


def fly_steered(course: Course, place: Place, plan: Plan, seconds: float, delay: float = 0.0) -> list[Sample]:
    """One of our steerings, planned for ``hummingbird``. ``delay``: s from a state to its setpoint's effect."""
    place.put(course.at(0.0))
    steering, table = plan.steering, plan.table
    state = place.state
    memory = steering.begin(state)
    link = Delayed(delay, control_of(RateSetpoint((0.0, 0.0, 0.0), HOVER)))
    s = table.locate(state.p_n)[0]
    while place.t < seconds:
        state = place.state
        s = table.nearest(state.p_n, s, 1.0 + 0.2 * math.hypot(*state.v_n))[0]
        aim = Along(s, smooth_start(place.t, plan.ramp_time))
        steered = steering.steer(memory, state, CONTROL_PERIOD if place.t else 0.0, aim)
        memory = steered.memory
        assert isinstance(steered.setpoint, RateSetpoint)
        link.send(place.t, control_of(steered.setpoint))
        place.step(link.at(place.t), CONTROL_PERIOD)
    return place.track
