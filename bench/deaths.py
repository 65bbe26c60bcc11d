"""What PX4 does when a companion dies, level by level, on the stand-in and its vehicle sih.

    python -m bench.deaths [circle]

0.12 s into a sidestep of 4 m out of a hover; with ``circle`` also on circle_r5 at 3 m/s. At three moments between two
of PX4's looks: as it was measured on PX4, soonest, latest. The tilt: at most until a second after PX4 acts.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from companion.vehicle import OutputLevel
from trials.deaths import death, sidestep

OFFBOARD = (OutputLevel.MOTORS, OutputLevel.TORQUES, OutputLevel.RATES)
OWN_MODE = (OutputLevel.ATTITUDE, OutputLevel.RATES, OutputLevel.TORQUES, OutputLevel.MOTORS)
PHASES = (0.04, 0.0, 0.08)
"""s after one of PX4's looks at which it dies: as measured on PX4, soonest and latest."""


def main() -> None:
    """Print a table."""
    ways = {"sidestep": sidestep, "circle": death} if "circle" in sys.argv[1:] else {"sidestep": sidestep}
    print("| dies in | flown in | at | PX4 acts after, s | with | tilt before and most, degrees | lost, m | |")
    print("|---|---|---|---|---|---|---|---|")
    for (name, die), (levels, own_mode) in itertools.product(ways.items(), ((OFFBOARD, False), (OWN_MODE, True))):
        for level in levels:
            found = [die(level, own_mode=own_mode, after_look=phase) for phase in PHASES]
            took = ", ".join(f"{each.took:.2f}" for each in found)
            tilts = ", ".join(f"{each.tilt_before:.0f} {each.tilt_max:.0f}" for each in found)
            lost, by = max(each.lost for each in found), found[0].mode.words
            end = "turned over" if any(each.tilt_max > 90.0 for each in found) else ""
            end = "crash" if any(each.fell for each in found) else end
            where = "our mode" if own_mode else "OFFBOARD"
            print(f"| {name} | {where} | {level.value} | {took} | {by} | {tilts} | {lost:.2f} | {end} |", flush=True)


if __name__ == "__main__":
    main()
