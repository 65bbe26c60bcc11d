"""The rival: a time-tracking geometric SE(3) controller (Lee et al.; Mellinger and Kumar) behind the law's seam.

Position and velocity errors against a point that moves by the clock, with acceleration and jerk fed forward, give the
thrust's direction; the attitude error on the sphere, with the direction's own turning fed forward, gives body rates.
Estimator, predictor, limits and encoding are the law's own: only what is asked for differs.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

from companion.frames import Matrix3, Vec3, wrap
from companion.law.flight import Command, Flying
from companion.law.speed_scale import SpeedScale
from companion.plan import Plan
from companion.steering.rate_memory import RateMemory
from companion.steering.rates import RateSteering
from companion.steering.steering import Aim, Along, Steered
from companion.vehicle import Setpoint, VehicleState
from trials.rivals.course import Course, Moment

POSITION, VELOCITY, ATTITUDE = 9.0, 6.0, 8.0
"""Gains on the errors of position (1/s^2), velocity (1/s) and attitude (1/s): the best of a sweep on these courses."""
THRUST = 25.0
"""1/s, how quickly the thrust that is sent comes to the one that is wanted."""
YAW, YAW_RATE_MAX, YAW_DIVISOR = 1.5, 1.5, 0.2
"""As the law's own."""


class TrackerMemory(NamedTuple):
    """The law's own memory, and the stamp at which the timetable began."""

    rates: RateMemory
    begun: float | None = None


@dataclass(frozen=True)
class Tracker:
    """See Steering. ``course`` is the timetable; ``rates`` is the steering that is made to ask for something else."""

    rates: RateSteering
    course: Course

    def begin(self, state: VehicleState) -> TrackerMemory:
        """See Steering."""
        return TrackerMemory(self.rates.begin(state))

    def steer(
        self, memory: TrackerMemory, state: VehicleState, dt: float, aim: Aim, round_trip: float | None = None
    ) -> Steered:
        """See Steering."""
        rates, begun = self.learn(memory)
        if begun is None and isinstance(aim, Along) and dt > 0.0:
            begun = state.t_boot
        t = 0.0 if begun is None else state.t_boot - begun
        delay = self.rates.vehicle.dead_time if round_trip is None else round_trip
        acts = t + delay + 0.5 * dt + self.rates.rate_loop.lag
        steered = self._for(acts).steer(rates, state, dt, aim, round_trip)
        return steered._replace(memory=TrackerMemory(steered.memory, begun))

    def learn(self, memory: TrackerMemory) -> TrackerMemory:
        """See Steering."""
        return memory._replace(rates=self.rates.learn(memory.rates))

    def _for(self, t: float) -> RateSteering:
        """The law's steering, asking for the moment ``t`` of the timetable."""
        return dataclasses.replace(self.rates, law=Tracking(self.course.at(t), self.rates), yaw_gain=YAW)

    def level_setpoint(self, state: VehicleState | None, memory: TrackerMemory | None = None) -> Setpoint:
        """See Steering."""
        return self.rates.level_setpoint(state, None if memory is None else memory.rates)


def tracking(plan: Plan, course: Course) -> Tracker:
    """The tracker in the place of a plan's own steering."""
    assert isinstance(plan.steering, RateSteering)
    return Tracker(plan.steering, course)


@dataclass(frozen=True)
class Tracking:
    """What the timetable asks for at a moment, in the place of a path's law."""

    moment: Moment
    rates: RateSteering

    def __call__(self, flying: Flying, ramp: SpeedScale) -> Command:
        """See Law."""
        moment = self.moment
        vehicle = self.rates.vehicle
        m, g, c = vehicle.mass, vehicle.gravity, flying.drag
        R, v, d = flying.r_nb, flying.v_n, flying.disturbance
        b = (R[2], R[5], R[8])
        specific_thrust = flying.zeta / m
        weight = (0.0, 0.0, g)
        a = _sum((1.0, weight), (-specific_thrust, b), (1.0, d), (-c, v))
        e, ev, ea = (_sum((1.0, x), (-1.0, y)) for x, y in zip((flying.p_n, v, a), moment[:3], strict=True))
        wanted = _sum((1.0, moment.a_n), (-POSITION, e), (-VELOCITY, ev))
        force = _sum((1.0, wanted), (-1.0, weight), (-1.0, d), (c, v))
        force_dot = _sum((1.0, moment.j_n), (-POSITION, ev), (-VELOCITY, ea), (c, a))
        size = max(math.sqrt(_dot(force, force)), 0.1 * g)
        axis = _sum((-1.0 / size, force))
        axis_dot = _sum((-1.0 / size, force_dot), (_dot(axis, force_dot) / size, axis))
        turn = _sum((1.0, _cross(axis, axis_dot)), (ATTITUDE, _cross(b, axis)))
        p, q, _ = _to_body(R, turn)
        yaw = math.atan2(R[3], R[0])
        psi_dot = -min(max(YAW * wrap(yaw), -YAW_RATE_MAX), YAW_RATE_MAX)
        d2 = R[0] ** 2 + R[3] ** 2
        divisor = math.copysign(max(abs(R[8]), YAW_DIVISOR), R[8])
        r = (psi_dot * d2 - (R[3] * R[2] - R[0] * R[5]) * q) / divisor
        thrust = -m * _dot(force, b)
        tangent = _sum((1.0 / max(math.sqrt(_dot(moment.v_n, moment.v_n)), 1e-3), moment.v_n))
        return Command(
            zeta_derivative=THRUST * (thrust - flying.zeta),
            turn=(p, q, min(max(r, -YAW_RATE_MAX), YAW_RATE_MAX)),
            tangent=tangent,
            speed=_dot(tangent, v),
            alpha=math.sqrt(_dot(moment.v_n, moment.v_n)),
            yaw=yaw,
            beta=0.0,
            regularity=1.0,
        )


def _sum(*terms: tuple[float, Vec3]) -> Vec3:
    return (
        sum(k * x[0] for k, x in terms), sum(k * x[1] for k, x in terms), sum(k * x[2] for k, x in terms)
    )  # fmt: skip


def _dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vec3, b: Vec3) -> Vec3:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _to_body(R: Matrix3, a: Vec3) -> Vec3:
    return (
        R[0] * a[0] + R[3] * a[1] + R[6] * a[2],
        R[1] * a[0] + R[4] * a[1] + R[7] * a[2],
        R[2] * a[0] + R[5] * a[1] + R[8] * a[2],
    )
