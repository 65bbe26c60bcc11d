"""Steps of the thrust scale in flight, and a battery that sags: ``python -m bench.payload [SEEDS]``.

sih_noisy, a steady wind of 3 m/s, files wrong by +-15 % in hover thrust and +-50 % in drag: the circle of 5 m at 3 and
5 m/s and a hover (0.1 m/s along it). A fifth of the mass falls off (the scale steps by 25 %), or all motors give a
fifth less; or the battery goes from full to a quarter in four minutes.
"""

from __future__ import annotations

import sys

from companion.world import Battery
from companion.world.events import After, Event, MotorFailure, PayloadDrop, When
from trials.consistency import Trial, trial
from trials.measured import steady_wind, world

SPEEDS = (3.0, 5.0, 0.1)
"""m/s."""
STEP_AT = 40.0
"""s after the hand-over."""
MASS_DROPPED = 0.2
"""kg of the vehicle's 1 kg."""
SAGGING = Battery(capacity=3600.0 * 1.7, resistance=0.02, full_current=60.0)
"""A pack of 1.7 Ah, which a hover empties in five minutes."""


def main(seeds: int) -> None:
    """Print a line a flight."""
    worst = 0.0
    for i, speed in enumerate(SPEEDS):
        for seed in range(10 * i, 10 * i + seeds):
            at = STEP_AT + 0.7 * seed
            drop = PayloadDrop(When(at, at, After.OFFBOARD), MASS_DROPPED)
            weaker = MotorFailure(When(at, after=After.OFFBOARD), None, 0.8)
            for event, words in ((drop, "a fifth of the mass falls off"), (weaker, "all motors give 80 %")):
                done = _flown(speed, seed, at + 12.0, (event,))
                after = [100.0 * done.scale_error(t) for t in (1.0, 2.0, 5.0, 10.0)]
                worst = max(worst, abs(after[2]))
                told = ", ".join(f"{value:+.1f}" for value in after)
                print(f"{speed:g} m/s, seed {seed:2d}, {words}: {told} % after 1, 2, 5, 10 s", flush=True)
    print(f"after 5 s: {worst:.1f} % at most")
    for i, speed in enumerate(SPEEDS):
        done = _flown(speed, i, 240.0, (), SAGGING)
        error = max(abs(w.scale) for w in done.windows if w.begin >= 20.0)
        first, last = done.scale[0, 2], done.scale[-1, 2]
        print(
            f"{speed:g} m/s, battery: scale {first:.2f} to {last:.2f}, off by {100.0 * error:.1f} % at most from 20 s"
        )


def _flown(
    speed: float, seed: int, duration: float, events: tuple[Event, ...], battery: Battery | None = None
) -> Trial:
    where = world("sih_noisy", wind_n=steady_wind(3.0, seed), events=events, battery=battery)
    hover, drag = (1.15, 0.85)[seed % 2], (0.5, 1.5)[seed // 2 % 2]
    return trial("circle_r5", speed, where, hover=hover, drag=drag, seed=seed, duration=duration)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
