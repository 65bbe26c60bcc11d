"""A thrust curve that PX4 was not told of, and what is found of it: ``python -m bench.thrust_curve [SEEDS]``.

sih_noisy in 3 m/s of wind, the file's hover thrust right or wrong by 15 %: circles of 5 m at 3, 5 and 7 m/s (tilt to
60 deg) and the figure-eight, with rotors of a curve of 0, 0.3 and 0.6 and THR_MDL_FAC 0. Printed: the slope beyond
proportion as it is, and its error and its own deviation after some seconds, over the seeds; believed errors from 10 s.
"""

from __future__ import annotations

import math
import sys

import numpy as np

from companion.calculus import machine_code
from trials.thrust_curve import LOOKED_AT, Flown, flown

FLIGHTS = (("circle_r5", 3.0), ("circle_r5", 5.0), ("circle_r5", 7.0), ("figure8", 3.0))
"""Mission, m/s."""
CURVES = (0.0, 0.3, 0.6)
"""What THR_MDL_FAC should be."""


def main(seeds: int) -> None:
    """Print a line for each course and curve, and how the errors compare with their deviations, by curve."""
    machine_code.use()
    ratios: dict[tuple[float, float], list[float]] = {}
    for mission, speed in FLIGHTS:
        for curve in CURVES:
            flights = [flown(mission, speed, curve, seed) for seed in range(seeds)]
            words = []
            for k, at in enumerate(LOOKED_AT):
                off = [each.found[k][0] - each.true for each in flights]
                stds = [each.found[k][1] for each in flights]
                ratios.setdefault((curve, at), []).extend(error / std for error, std in zip(off, stds, strict=True))
                words.append(f"{at:g} s {np.mean(off):+.3f} +- {np.std(off):.3f} ({np.mean(stds):.3f})")
            print(f"{mission} {speed:g} m/s, curve {curve}: {', '.join(words)}; {_held(flights, speed)}", flush=True)
    for (curve, at), each in ratios.items():
        rms = float(np.sqrt(np.mean(np.square(each))))
        print(f"curve {curve}, {at:g} s: errors over deviations {np.mean(each):+.2f}, root mean square {rms:.2f}")


def _held(flights: list[Flown], speed: float) -> str:
    held = [each.flight.believed for each in flights if each.flight.believed is not None]
    lost = sum(each.flight.reason is not None for each in flights)
    path, off, yaw = (float(np.mean([getattr(each, name) for each in held])) for name in ("path", "speed", "yaw"))
    words = f"path {100.0 * path:.2f} cm, speed {100.0 * off / speed:.1f} %, heading {math.degrees(yaw):.1f} deg"
    return f"{words}, LOST {lost}" if lost else words


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 6)
