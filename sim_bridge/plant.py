"""The machine: motor commands in, its true state out, one fixed step at a time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from companion.frames import Quaternion, Vec3
from companion.vehicle import Vehicle
from companion.world import World
from sim_bridge import environment
from sim_bridge.battery import Cells
from sim_bridge.gusts import GustyAir
from sim_bridge.integrate import Motion, advance_of
from sim_bridge.noise import RandomStream, normals
from sim_bridge.rigid_body import body_of, true_vehicle
from sim_bridge.rotors import Four, lagging, spinning, thrust_wanted

BODY_RATE_MAX = 100.0
"""rad/s. Beyond this the fixed step no longer resolves the turning; a body rate stops here, as in PX4's SIH at 19."""

OFF: Four = (0.0, 0.0, 0.0, 0.0)
"""N, of each rotor."""
STILL: Vec3 = (0.0, 0.0, 0.0)
"""m/s or rad/s."""


class Truth(NamedTuple):
    """The true state at one moment."""

    t_boot: float  # s
    p_n: Vec3  # m
    v_n: Vec3  # m/s
    a_n: Vec3  # m/s^2, the mean over the last step
    q_nb: Quaternion  # body to world
    w_b: Vec3  # rad/s
    rotor_thrusts: Four  # N, in motor order
    on_ground: bool  # whether it rests on the ground

    @property
    def thrust(self) -> float:
        """The sum of the rotors' thrusts, N."""
        return sum(self.rotor_thrusts)


class Plant:
    """A vehicle in a world. ``step_s``: the fixed step. The clock counts steps, so that times are exact.

    ``vehicle`` is the true one: ``true_vehicle`` of what the companion believes. ``cells``: its battery, None where
    there is none that sags. ``seed``: of the gusts. What disturbs it lasts until it is set again:
    ``wind_n`` the mean wind (m/s), ``push_n`` a force (N), ``left`` the share of its thrust a rotor still gives,
    ``is_held`` whether somebody holds it fast.
    """

    def __init__(self, vehicle: Vehicle, world: World, steps_per_second: int, seed: int = 0) -> None:
        self.vehicle = true_vehicle(vehicle, world.truth)
        self.world = world
        self.steps_per_second = steps_per_second
        self.step_s = 1.0 / steps_per_second
        self._wanted = thrust_wanted(self.vehicle.rotors, world.truth.thrust_curve)
        rotors = world.truth.rotors
        self._spins = rotors is not None
        self._course = (
            lagging(self.step_s, self.vehicle.motor_lag)
            if rotors is None
            else spinning(self.step_s, self.vehicle.rotors, rotors)
        )
        self._reactions = tuple(rotor.spin.reaction * rotor.torque_per_thrust for rotor in self.vehicle.rotors)
        self._deviations = world.truth  # a payload that falls off changes them
        self._advance = advance_of(body_of(self.vehicle, world.truth), self.step_s)
        self._gusts = (
            None
            if world.gusts is None
            else GustyAir(world.gusts, world.wind_n, self.step_s, normals(seed, RandomStream.GUSTS))
        )
        self.cells = None if world.battery is None else Cells(world.battery, self.vehicle.thrust_max)
        self.wind_n = world.wind_n
        self.push_n = STILL
        self._gravity_n: Vec3 = (0.0, 0.0, self.vehicle.gravity)
        self.left: Four | None = None
        self.is_held = False
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
        self._a_n: Vec3 = STILL
        self._on_ground = True
        self._truth: Truth | None = None

    def fly(self, p_n: Vec3, v_n: Vec3, q_nb: Quaternion, w_b: Vec3, thrusts: Four) -> None:
        """Put the vehicle in the air. Where that is not above the ground plane, there is no ground."""
        self._motion = (*p_n, *v_n, *q_nb, *w_b)
        self._thrusts = thrusts
        self._a_n = STILL
        self._on_ground = False
        self._has_ground = p_n[2] < 0.0
        self._truth = None

    def drop(self, mass: float) -> None:
        """What hung below the centre of mass falls off: so much lighter (kg), with the same drag and inertia."""
        truth, more = self._deviations, self.vehicle.mass / (self.vehicle.mass - mass)
        self.vehicle = replace(self.vehicle, mass=self.vehicle.mass - mass, drag=self.vehicle.drag * more)
        self._deviations = replace(
            truth, rotor_drag=truth.rotor_drag * more, quadratic_drag=truth.quadratic_drag * more
        )
        self._advance = advance_of(body_of(self.vehicle, self._deviations), self.step_s)

    def thrusts_of(self, commands: Four) -> Four:
        """The thrusts (N) that motor commands lead to in the end."""
        wanted = self._wanted(commands)
        if self.cells is not None:
            k = self.cells.strength
            wanted = (k * wanted[0], k * wanted[1], k * wanted[2], k * wanted[3])
        if self.left is not None:
            a, b, c, d = self.left
            wanted = (a * wanted[0], b * wanted[1], c * wanted[2], d * wanted[3])
        return wanted

    @property
    def truth(self) -> Truth:
        """The true state now."""
        if self._truth is None:
            self._truth = self._state()
        return self._truth

    def _state(self) -> Truth:
        pn, pe, pd, vn, ve, vd, w, x, y, z, p, q, r = self._motion
        t = self.steps / self.steps_per_second
        return Truth(t, (pn, pe, pd), (vn, ve, vd), self._a_n, (w, x, y, z), (p, q, r), self._thrusts, self._on_ground)

    def step(self, commands: Four | None) -> None:
        """Let one step pass under motor commands in the rotors' own units; None: the motors are switched off.

        A rotor whose range begins above zero idles at the bottom of it, but only while it is switched on.
        """
        wanted = OFF if commands is None else self.thrusts_of(commands)
        thrusts = self._course(self._thrusts, wanted)
        motion = self._motion
        self.steps += 1
        self._truth = None
        self._thrusts = thrusts[2]
        wind_n = self.wind_n if self._gusts is None else self._gusty_wind()
        if self.cells is not None:
            self.cells.update(sum(self._thrusts), self.step_s)
        if self.is_held or (self._on_ground and not self._leaves_the_ground()):
            self._motion = environment.at_rest(motion, self.step_s) if self._on_ground else environment.held(motion)
            self._a_n = STILL
            return
        self._on_ground = False
        after = self._advance(
            motion, thrusts, wind_n, self._outer_acceleration(), self._turn(wanted) if self._spins else 0.0
        )
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

    def _leaves_the_ground(self) -> bool:
        """Whether the rotors, and whoever pushes, lift more than it weighs."""
        lift = sum(self._thrusts) * environment.cosine_of_tilt(self._motion) - self.push_n[2]
        return lift > self.vehicle.weight

    def _outer_acceleration(self) -> Vec3:
        """What accelerates beside rotors and air: gravity and pushes, m/s^2."""
        if self.push_n is STILL:
            return self._gravity_n
        north, east, down = self.push_n
        mass = self.vehicle.mass
        return (north / mass, east / mass, down / mass + self.vehicle.gravity)

    def _turn(self, wanted: Four) -> float:
        """The torque about z (N m) that the motors' torques put on the frame."""
        return sum(reaction * thrust for reaction, thrust in zip(self._reactions, wanted, strict=True))

    def _gusty_wind(self) -> Vec3:
        assert self._gusts is not None
        wn, we, wd = self.wind_n
        motion = self._motion
        gn, ge, gd = self._gusts.update(-motion[2], (motion[3] - wn, motion[4] - we, motion[5] - wd))
        return (wn + gn, we + ge, wd + gd)
