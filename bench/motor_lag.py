"""Motors that are not as slow as the vehicle file says, and what is found of their lag: ``python -m bench.motor_lag``.

Circle of 5 m and figure-eight in sih_noisy and sih; the lag as told (file) and as it is. Believed errors of following
from 8 s on; how fast zeta moves, which is where a wrong lag shows first.
"""

from __future__ import annotations

import math

import numpy as np

from companion.daemon.conductor import Conductor
from companion.flight.phases import Phase
from companion.steering.rates import RateMemory
from companion.world import Deviations
from sim_bridge.plant import Truth
from trials.measured import course, machine, measure_flight, world

FLIGHTS = (
    (0.05, 0.05, "circle_r5", 3.0, "sih_noisy"),
    (0.025, 0.06, "circle_r5", 3.0, "sih_noisy"),
    (0.06, 0.025, "circle_r5", 3.0, "sih_noisy"),
    (0.05, 0.015, "circle_r5", 5.0, "sih_noisy"),
    (0.025, 0.06, "figure8", 3.0, "sih_noisy"),
    (0.025, 0.06, "circle_r5", 5.0, "sih"),
    (0.05, 0.05, "circle_r5", 7.0, "sih"),
)
"""s as told, s as it is, mission, m/s, world."""
LOOKED_AT = (4.0, 6.0, 10.0, 20.0, 40.0)
"""s after the hand-over."""


def main() -> None:
    """Print a line a flight."""
    for told, true, mission, speed, where in FLIGHTS:
        print(_flown(told, true, mission, speed, where), flush=True)


def _flown(told: float, true: float, mission: str, speed: float, where: str) -> str:
    file = machine("sih", motor_lag=told)
    lags: list[tuple[float, float, float]] = []
    slopes: list[float] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        steered = conductor.last.outcome.steered if conductor.last is not None else None
        if steered is None or conductor.memory is None or not isinstance(steered.memory, RateMemory):
            return
        lags.append((now, *steered.memory.estimate.motion.estimator.motor_lag))
        if conductor.memory.phase is Phase.FOLLOW:
            slopes.append(steered.zeta_dot / file.weight)

    done = measure_flight(
        course(mission, speed), file, world(where, truth=Deviations(motor_lag=true)), seed=3, duration=45.0, settle=8.0,
        watch=watch,
    )  # fmt: skip
    t, lag, variance = np.array(lags).T
    at = np.searchsorted(t, t[0] + np.array(LOOKED_AT))
    found = ", ".join(f"{1e3 * lag[i]:.0f} +- {1e3 * math.sqrt(variance[i]):.0f}" for i in at)
    late = np.array(slopes[len(slopes) // 2 :])
    believed = done.believed
    return (
        f"{where}, {mission} {speed:g} m/s, told {1e3 * told:.0f}, is {1e3 * true:.0f} ms: path "
        f"{100.0 * believed.path:.2f} cm, speed {100.0 * believed.speed / speed:.1f} %, zeta_dot "
        f"{np.sqrt(np.mean(late**2)):.2f} weights a second; found {found} ms after "
        f"{', '.join(f'{s:g}' for s in LOOKED_AT)} s"
    )


if __name__ == "__main__":
    main()
