"""Random airframes with rough files, sensors that shake and wind: see trials.airframes.

python -m bench.airframes [flights] [first seed]

Each flies the circle and the figure-eight with its nose along the path, both at 3 m/s for 25 s; figures are what the
vehicle believes (true in brackets), from 15 s on. ``motors``: the largest share of a motor's range that the
figure-eight asks for; beyond 1 its yaw torque does not allow the heading.
"""

from __future__ import annotations

import math
import sys

from companion.calculus import machine_code
from trials.airframes import drawn, flown, motor_share
from trials.measured import Measured


def main(count: int, first: int) -> None:
    """Print a line an airframe and the sum of it."""
    machine_code.use()
    paths: list[float] = []
    yaws: list[float] = []
    lost = excepted = 0
    print("seed airframe motors | circle: path cm, most, speed % | figure-eight: path cm, speed %, yaw deg, tilt deg")
    for seed in range(first, first + count):
        airframe = drawn(seed)
        share = motor_share(airframe)
        circle, eight = flown(seed, circle=True), flown(seed)
        print(f"{seed:4} {airframe.words()} {share:4.2f} | {_path(circle)} | {_yaw(eight)}", flush=True)
        lost += circle.reason is not None or eight.reason is not None
        if circle.reason is None and circle.believed is not None:
            paths.append(100.0 * circle.believed.path)
        if share > 1.0:
            excepted += 1
        elif eight.reason is None and eight.believed is not None:
            yaws.append(math.degrees(eight.believed.yaw))
    near = 100.0 * sum(path <= 3.0 for path in paths) / count
    print(f"lost {lost} of {count}; circle: {near:.1f} % within 3 cm, worst {max(paths, default=math.nan):.1f}")
    worst = max(yaws, default=math.nan)
    print(
        f"yaw: {sum(yaw <= 3.0 for yaw in yaws)} of {len(yaws)} within 3 deg, worst {worst:.1f}; not allowed {excepted}"
    )


def _path(done: Measured) -> str:
    if done.reason is not None or done.believed is None or done.true is None:
        return f"LOST: {done.reason}"
    path, true, most = (100.0 * value for value in (done.believed.path, done.true.path, done.believed.path_max))
    return f"{path:4.2f} ({true:4.1f}) {most:4.1f} {done.believed.speed / 0.03:3.1f}"


def _yaw(done: Measured) -> str:
    if done.reason is not None or done.believed is None or done.true is None:
        return f"LOST: {done.reason}"
    yaw, true, tilt = (math.degrees(value) for value in (done.believed.yaw, done.true.yaw, done.tilt_max))
    return f"{100.0 * done.believed.path:4.2f} {done.believed.speed / 0.03:3.1f} {yaw:4.2f} ({true:4.2f}) {tilt:2.0f}"


if __name__ == "__main__":
    asked = [int(word) for word in sys.argv[1:3]]
    main(asked[0] if asked else 10, asked[1] if len(asked) > 1 else 0)
