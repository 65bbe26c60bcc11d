"""Random airframes with rough files, sensors that shake and wind: see trials.airframes.

python -m bench.airframes [flights] [first seed] [circle]
"""

from __future__ import annotations

import math
import sys

from trials.airframes import drawn, flown


def main() -> None:
    """Print a line a flight and the sum of it."""
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    count, first = (numbers + [10, 0][len(numbers) :])[:2]
    circle = "circle" in sys.argv
    paths, yaws, lost = [], [], 0
    print("seed airframe | path cm, believed (true, max)  speed %  yaw deg, believed (true)  tilt deg")
    for seed in range(first, first + count):
        words, result = drawn(seed).words(), flown(seed, circle=circle)
        if result.reason is not None or result.true is None or result.believed is None:
            lost += 1
            print(f"{seed:4} {words} | LOST: {result.reason}", flush=True)
            continue
        true, believed = result.true, result.believed
        paths.append(100.0 * believed.path)
        yaws.append(math.degrees(believed.yaw))
        print(
            f"{seed:4} {words} | {paths[-1]:5.2f} ({100.0 * true.path:5.2f}, {100.0 * true.path_max:5.1f}) "
            f"{believed.speed / 0.03:5.1f}  {yaws[-1]:5.2f} ({math.degrees(true.yaw):5.2f})  "
            f"{math.degrees(result.tilt_max):3.0f}",
            flush=True,
        )
    if paths:
        paths.sort()
        yaws.sort()
        near = 100.0 * sum(path <= 3.0 for path in paths) / count
        print(
            f"path: {near:.0f} % within 3 cm, worst {paths[-1]:.1f}; yaw: worst {yaws[-1]:.1f} deg; "
            f"lost {lost} of {count}"
        )


if __name__ == "__main__":
    main()
