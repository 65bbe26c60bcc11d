"""The machine: motor commands in, its true state out, one fixed step at a time."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Quaternion, Vec3
from companion.vehicle import Vehicle
from companion.world import World
from sim_bridge import environment
from sim_bridge.integrate import Motion, runge_kutta
from sim_bridge.rigid_body import body_of, derivative_of, true_vehicle
from sim_bridge.rotors import Four, Lag, course, thrust_wanted

BODY_RATE_MAX = 100.0
"""rad/s. Beyond this the fixed step no longer resolves the turning; a body rate stops here, as in PX4's SIH at 19."""

OFF: Four = (0.0, 0.0, 0.0, 0.0)


class Truth(NamedTuple):
    """The true state at one moment.

    ``t_boot`` s, ``p_n`` m, ``v_n`` m/s, ``a_n`` the mean acceleration over the last step in m/s^2, ``q_nb`` body to
    world, ``w_b`` rad/s, ``rotor_thrusts`` N in motor order, ``on_ground`` whether it rests on the ground.
    """

    t_boot: float
    p_n: Vec3
    v_n: Vec3
    a_n: Vec3
    q_nb: Quaternion
    w_b: Vec3
    rotor_thrusts: Four
    on_ground: bool

    @property
    def thrust(self) -> float:
        """The sum of the rotors' thrusts, N."""
        return sum(self.rotor_thrusts)


class Plant:
    """A vehicle in a world. ``step_s``: the fixed step. The clock counts steps, so that times are exact.

    ``vehicle`` is the true one: ``true_vehicle`` of what the companion believes.
    """

    def __init__(self, vehicle: Vehicle, world: World, steps_per_second: int) -> None:
        self.vehicle = true_vehicle(vehicle, world.truth)
        self.world = world
        self.steps_per_second = steps_per_second
        self.step_s = 1.0 / steps_per_second
        self._wanted = thrust_wanted(self.vehicle.rotors)
        self._lag = Lag.over(self.step_s, self.vehicle.motor_lag)
        self._advance = runge_kutta(derivative_of(body_of(self.vehicle, world.truth.angular_drag)), self.step_s)
        self._has_ground = True
        self.steps = 0
        self.rest()

    def rest(self, heading: float = 0.0) -> None:
        """Put the vehicle on the ground at the origin, rotors still."""
        half = 0.5 * heading
        self._motion: Motion = (
            *(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            *(math.cos(half), 0.0, 0.0, math.sin(half)),
            *(0.0, 0.0, 0.0),
        )
        self._thrusts = OFF
        self._a_n: Vec3 = (0.0, 0.0, 0.0)
        self._on_ground = True

    def fly(self, p_n: Vec3, v_n: Vec3, q_nb: Quaternion, w_b: Vec3, thrusts: Four) -> None:
        """Put the vehicle in the air. Where that is not above the ground plane, there is no ground."""
        self._motion = (*p_n, *v_n, *q_nb, *w_b)
        self._thrusts = thrusts
        self._a_n = (0.0, 0.0, 0.0)
        self._on_ground = False
        self._has_ground = p_n[2] < 0.0

    def thrusts_of(self, commands: Four) -> Four:
        """The thrusts (N) that motor commands lead to in the end."""
        return self._wanted(commands)

    @property
    def truth(self) -> Truth:
        """The true state now."""
        pn, pe, pd, vn, ve, vd, w, x, y, z, p, q, r = self._motion
        t = self.steps / self.steps_per_second
        return Truth(t, (pn, pe, pd), (vn, ve, vd), self._a_n, (w, x, y, z), (p, q, r), self._thrusts, self._on_ground)

    def step(self, commands: Four | None) -> None:
        """Let one step pass under motor commands in the rotors' own units; None: the motors are switched off.

        A rotor whose range begins above zero idles at the bottom of it, but only while it is switched on.
        """
        wanted = OFF if commands is None else self._wanted(commands)
        thrusts = course(self._lag, self._thrusts, wanted)
        motion = self._motion
        self.steps += 1
        self._thrusts = thrusts[2]
        if self._on_ground:
            lift = sum(self._thrusts) * environment.cosine_of_tilt(motion)
            if lift <= self.vehicle.weight:
                self._motion = environment.at_rest(motion, self.step_s)
                self._a_n = (0.0, 0.0, 0.0)
                return
            self._on_ground = False
        after = self._advance(motion, thrusts, environment.wind(self.world))
        if abs(after[10]) > BODY_RATE_MAX or abs(after[11]) > BODY_RATE_MAX or abs(after[12]) > BODY_RATE_MAX:
            p, q, r = (max(-BODY_RATE_MAX, min(BODY_RATE_MAX, rate)) for rate in after[10:])
            after = (*after[:10], p, q, r)
        if self._has_ground and environment.has_touched_down(after):
            after = environment.at_rest(after, self.step_s)
            self._on_ground = True
        per_step = self.steps_per_second
        self._a_n = (
            (after[3] - motion[3]) * per_step, (after[4] - motion[4]) * per_step, (after[5] - motion[5]) * per_step
        )  # fmt: skip
        self._motion = after
