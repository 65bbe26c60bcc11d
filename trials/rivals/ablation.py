"""The law's own steering with one of its remedies taken away, to see what each is worth."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

from companion.estimation.estimator import Prior
from companion.estimation.kalman_step import AXES, DISTURBANCE, DRAG, GUST, PER_AXIS, VELOCITY_ERROR, WANDER
from companion.estimation.motion_estimate import motion_of
from companion.estimation.rate_loop_model import alike
from companion.plan import Plan
from companion.steering.rate_memory import RateMemory
from companion.steering.rates import RateSteering
from companion.steering.steering import Steering

KNOWN = 1e-9
"""A standard deviation that leaves nothing to learn."""
NO_LAG = 1e-3
"""s; a lag of nothing."""
PUSHES = tuple(PER_AXIS * axis + kind for axis in range(AXES) for kind in (DISTURBANCE, GUST))
"""Where the filter keeps the disturbance."""
BIAS = tuple(PER_AXIS * axis + kind for axis in range(AXES) for kind in (WANDER, VELOCITY_ERROR))
"""Where it keeps the errors of the vehicle's own estimate."""


@dataclass(frozen=True, slots=True)
class Forgetful(RateSteering):
    """Some of the filter's numbers are put back to zero at every step, so that they are never used."""

    forgotten: tuple[int, ...] = ()

    def learn(self, memory: RateMemory) -> RateMemory:
        """See Steering."""
        memory = RateSteering.learn(self, memory)
        estimate = memory.estimate
        motion = estimate.motion
        belief = motion.estimator.belief
        x = tuple(0.0 if i in self.forgotten else value for i, value in enumerate(belief.x))
        estimator = motion.estimator._replace(belief=belief._replace(x=x))
        # everything that follows from the belief is made anew, the forces too; what a heading error makes is left out
        motion = motion_of(motion.state, estimator, motion.gravity, (0.0, 0.0, 0.0))
        return memory._replace(estimate=estimate._replace(motion=motion))


def without(remedy: str) -> Callable[[Plan], Steering]:
    """The steering of a plan without one of REMEDIES."""
    change = REMEDIES[remedy]

    def changed(plan: Plan) -> Steering:
        assert isinstance(plan.steering, RateSteering)
        return change(plan.steering)

    return changed


def _forgetful(steering: RateSteering, *forgotten: int) -> RateSteering:
    fields = {field.name: getattr(steering, field.name) for field in dataclasses.fields(steering)}
    return Forgetful(**fields, forgotten=forgotten)


def _no_drag(steering: RateSteering) -> RateSteering:
    return _forgetful(dataclasses.replace(steering, prior=Prior(steering.prior.thrust_scale, (0.0, KNOWN))), DRAG)


def _no_scale(steering: RateSteering) -> RateSteering:
    return dataclasses.replace(steering, prior=Prior((1.0, KNOWN), steering.prior.drag))


def _nothing(steering: RateSteering) -> RateSteering:
    plain = dataclasses.replace(
        steering, prior=Prior((1.0, KNOWN), (0.0, KNOWN)), rate_loop=alike(NO_LAG, steering.rate_loop.motor_lag)
    )
    return _forgetful(plain, *PUSHES, *BIAS, DRAG)


def _no_prediction(steering: RateSteering) -> RateSteering:
    return dataclasses.replace(steering, rate_loop=alike(NO_LAG, steering.rate_loop.motor_lag))


REMEDIES: dict[str, Callable[[RateSteering], RateSteering]] = {
    "everything on": lambda steering: steering,
    "no prediction over the rate loop": _no_prediction,
    "no drag": _no_drag,
    "no disturbance": lambda steering: _forgetful(steering, *PUSHES),
    "no bias between velocity and position": lambda steering: _forgetful(steering, *BIAS),
    "no thrust scale": _no_scale,
    "none of them": _nothing,
}
