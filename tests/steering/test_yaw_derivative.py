"""The yaw rate that the law will ask for is looked for whether or not the filter has waited for it."""

from __future__ import annotations

import pytest

from companion.law.speed_scale import SpeedScale
from companion.plan import prepared
from companion.steering.rates import RateSteering
from companion.steering.steering import Along
from companion.vehicle import OutputLevel, VehicleState
from trials.measured import course, machine

STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("jumps", [False, True], ids=["as predicted", "an innovation that cannot wait"])
def test_it_is_taken_of_every_other_state(jumps: bool) -> None:
    """An innovation that cannot wait is learned before the setpoint. Once that left the derivative where it stood: in
    sih_noisy for seconds, at -230 deg/s^2, which swung the nose by 19 deg."""
    steering = prepared(course("circle_r5", 5.0), machine("sih"), OutputLevel.RATES, STILL).steering
    assert isinstance(steering, RateSteering)
    state = VehicleState(0.0, (0.0, 5.0, -10.0), (5.0, 0.0, 0.0), (0.96, 0.28, 0.0, 0.0), STILL)
    memory, derivatives, requested = steering.begin(state), [], 0
    for k in range(1, 9):
        x, y, z = state.p_n
        later = state._replace(t_boot=0.01 * k, p_n=(x + 0.05 * k, y + (0.4 * (-1) ** k if jumps else 0.0), z))
        memory = steering.steer(memory, later, 0.01, Along(0.0, SpeedScale(1.0, 0.0, 0.0))).memory
        requested += memory.yaw.pending is not None
        assert (memory.estimate.motion.pending is None) == jumps
        memory = steering.learn(memory)
        assert memory.yaw.pending is None
        assert steering.learn(memory) is memory
        derivatives.append(memory.yaw.ahead)
    assert requested == 4
    assert len(set(derivatives)) == 4
