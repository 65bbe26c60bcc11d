"""How well a flight could tell the thrust curve and the motors' lag at best: ``python -m bench.thrust_model``.

The Cramer-Rao bound over the first 15 s under the companion (flight to the path and beginning of the path) and over all
of 60 s, from positions and velocities as the vehicle reports them, in sih and sih_noisy with 3 m/s of wind; and of a
take-off of PX4: 1.5 m/s^2 upwards for a second, and the same downwards.
"""

from __future__ import annotations

import dataclasses

from companion.daemon.conductor import Conductor
from companion.world import Start, World
from sim_bridge.plant import Truth
from trials.measured import course, machine, measure_flight, world
from trials.thrust_model import Bound, Known, bound

COURSES = (("circle_r5", 3.0), ("circle_r5", 5.0), ("figure8", 3.0), ("helix", 1.5))
"""m/s."""
FIRST = 15.0
"""s."""
TAKE_OFF = 1.5
"""m/s^2, of PX4's take-off: to 1.5 m/s (MPC_TKO_SPEED) in a second."""


def main() -> None:
    """Print a line a flight."""
    for name in ("sih", "sih_noisy"):
        where = dataclasses.replace(world(name), wind_n=(2.0, -2.2, 0.0))
        for mission, speed in COURSES:
            flown = _flown(mission, speed, where)
            begun = flown[0].state.t_boot
            early = [known for known in flown if known.state.t_boot - begun <= FIRST]
            print(
                f"{name}, {mission} {speed:g} m/s: first {FIRST:g} s {_words(early)}; all {_words(flown)}", flush=True
            )
            if (mission, speed) == COURSES[0]:
                print(f"{name}, a take-off's thrust in a hover: {_words(_taking_off(early))}", flush=True)


def _flown(mission: str, speed: float, where: World) -> list[Known]:
    """What the filter had at each state, from a hover 3 m beside the path on."""
    flown: list[Known] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        memory = conductor.memory
        if memory is None or memory.steering is None or memory.steering.memory is None:
            return
        estimate = memory.steering.memory.estimate
        state = estimate.motion.state
        if estimate.motion.estimator.flight_time > 0.0 and (not flown or state.t_boot > flown[-1].state.t_boot):
            flown.append(Known(state, estimate.rate_loop_state.specific_thrust, estimate.motion.estimator))

    start = Start.hover((8.0, 0.0, -10.0))
    measure_flight(course(mission, speed), machine("sih"), where, duration=45.0, start=start, watch=watch)
    return flown


def _taking_off(flown: list[Known]) -> list[Known]:
    """The same states and noise, with the thrust of a hover and a take-off."""
    begun, hover = flown[0].state.t_boot, flown[0].thrust
    changed = []
    for known in flown:
        since = known.state.t_boot - begun
        more = TAKE_OFF if 2.0 < since < 3.0 else -TAKE_OFF if 8.0 < since < 9.0 else 0.0
        changed.append(known._replace(thrust=hover + more))
    return changed


def _words(flown: list[Known]) -> str:
    found: Bound = bound(flown, machine("sih").gravity, machine("sih").motor_lag)
    curve, lag = found.together
    return f"curve +-{found.curve:.2f}, lag +-{1e3 * found.lag:.0f} ms (neither known: {curve:.2f}, {1e3 * lag:.0f} ms)"


if __name__ == "__main__":
    main()
