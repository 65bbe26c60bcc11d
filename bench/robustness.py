"""Many seeded flights outdoors with a machine that is not as its file says: how far off the path, how many lost.

Each flight draws, from its seed: mass +-20 %, inertia +-30 %, motor lag 15-60 ms, link delay 0-50 ms there and back,
and a path (circle r 5 at 3 or 6 m/s, figure-eight at 3 m/s). The vehicle file stays as it is: nothing of this is told.

    python -m bench.robustness [flights] [first seed]
"""

from __future__ import annotations

import math
import sys

from trials.robustness import drawn, flown


def main() -> None:
    """Print a line a flight and the sum of it."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    paths, lost = [], 0
    print("seed  path          mass   inertia  lag ms  delay ms | true path cm (max)  speed %  yaw deg")
    for seed in range(first, first + count):
        case, result = drawn(seed), flown(seed)
        truth = case.truth
        assert truth.mass is not None
        assert truth.inertia is not None
        assert truth.motor_lag is not None
        words = (
            f"{seed:4}  {case.mission:9} {case.speed:.0f}  {truth.mass / 2.0:5.2f}  {truth.inertia[2] / 0.04:6.2f}"
            f"  {truth.motor_lag * 1e3:6.0f}  {case.delay * 1e3:7.0f}"
        )
        if result.reason is not None or result.true is None:
            lost += 1
            print(f"{words} | LOST: {result.reason}", flush=True)
            continue
        true = result.true
        paths.append(true.path * 100.0)
        print(
            f"{words} | {true.path * 100:8.2f} ({true.path_max * 100:5.1f})  {true.speed / case.speed * 100:9.1f}"
            f"  {math.degrees(true.yaw):7.2f}",
            flush=True,
        )
    if paths:
        print(f"worst {max(paths):.2f} cm, median {sorted(paths)[len(paths) // 2]:.2f} cm, lost {lost} of {count}")


if __name__ == "__main__":
    main()
