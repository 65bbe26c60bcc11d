"""`check` against flight: fifty random missions, what it says they ask for and what flying them does.

    python bench/agreement.py [COUNT] [motors|rates]

The missions are of every kind of closed curve, speed and yaw, at 55 to 95 % of the fastest speed that `check` allows.
The flights are on the ideal plant, in lockstep, one settled lap each. The same missions, faster than that: `check` must
say no, and where. Below, the largest errors of the shipped missions.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import companion
from companion.config.syntax.file_lookup import names
from trials.agreement import LAP_MAX, Extremes, asked, flown, random_mission, scaled

VEHICLE = "x500"


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    output = sys.argv[2] if len(sys.argv) > 2 else "motors"
    print("mission  share  thrust N predicted/flown      tilt deg     motors predicted/flown    off by  cm, %, deg")
    worst, seed, done = [0.0] * len(Extremes._fields), 0, 0
    refused = 0
    while done < count:
        seed += 1
        share = 0.55 + 0.4 * ((seed * 0.381966) % 1.0)
        mission, check = scaled(random_mission(seed), share, VEHICLE, output)
        if check.report.duration > LAP_MAX:
            continue
        done += 1
        said, did = asked(check), flown(mission, VEHICLE, output, check.report.duration)
        off = [abs(b - a) / abs(a) for a, b in zip(said, did.extremes, strict=True)]
        worst = [max(a, b) for a, b in zip(worst, off, strict=True)]
        a, b = said, did.extremes
        print(
            f"{seed:5}    {share:.2f}  {a.thrust_min:6.2f}/{b.thrust_min:6.2f} {a.thrust_max:6.2f}/{b.thrust_max:6.2f}"
            f"   {math.degrees(a.tilt_max):5.2f}/{math.degrees(b.tilt_max):5.2f}"
            f"   {a.motor_min:.3f}/{b.motor_min:.3f} {a.motor_max:.3f}/{b.motor_max:.3f}  {100 * max(off):6.2f} %"
            f"  {100 * did.path_error:.2f} {100 * did.speed_error:.2f} {math.degrees(did.yaw_error):.2f}",
            flush=True,
        )
        _, faster = scaled(random_mission(seed), 1.05 + 0.5 * (seed % 7) / 7.0, VEHICLE, output)
        place = f"{faster.report.tightest.at_s:.1f} m along the path"
        refused += not faster.feasible and place in faster.headline
    print("worst: " + ", ".join(f"{n} {100 * w:.2f} %" for n, w in zip(Extremes._fields, worst, strict=True)))
    print(f"of {count} too fast, refused with the place: {refused}")
    for name in names("missions"):
        if name.startswith("paper"):  # of another vehicle, without limits
            continue
        mission = companion.load_mission(name)
        if mission.value.closed:
            did = flown(mission, VEHICLE, output, companion.check(mission, VEHICLE, output=output).report.duration)
            print(
                f"{name:12} path {100 * did.path_error:.2f} cm, speed {100 * did.speed_error:.2f} %, "
                f"yaw {math.degrees(did.yaw_error):.2f} deg",
                flush=True,
            )


if __name__ == "__main__":
    main()
