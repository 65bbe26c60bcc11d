"""A remedy that is taken away is away: what the comparison with rivals says of each depends on it."""

from __future__ import annotations

from companion.plan import prepared
from companion.steering.rates import RateSteering
from companion.vehicle import OutputLevel, VehicleState
from trials.measured import course, machine
from trials.rivals.ablation import without

STILL = (0.0, 0.0, 0.0)


def test_a_disturbance_that_is_forgotten_is_in_no_command() -> None:
    plan = prepared(course("circle_r5", 3.0), machine("sih"), OutputLevel.RATES, STILL)
    leaning = VehicleState(0.0, (0.0, 5.0, -10.0), STILL, (0.995, 0.1, 0.0, 0.0), STILL)  # a hover in wind
    after = leaning._replace(t_boot=0.01)
    pushes = []
    for steering in (plan.steering, without("no disturbance")(plan)):
        assert isinstance(steering, RateSteering)
        memory = steering.begin(leaning)
        memory = steering._estimate(memory, after, 0.01, None)
        pushes.append(steering.learn(memory).estimate.motion.forces.disturbance_n)
    assert abs(pushes[0][1]) > 1.0
    assert pushes[1][:2] == (0.0, 0.0)
