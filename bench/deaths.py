"""What PX4 does when a companion dies on circle_r5 at 3 m/s, level by level: the stand-in, vehicle and world sih."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from companion.vehicle import OutputLevel
from trials.deaths import death

OFFBOARD = (OutputLevel.MOTORS, OutputLevel.TORQUES, OutputLevel.RATES)
OWN_MODE = (OutputLevel.ATTITUDE, OutputLevel.RATES, OutputLevel.TORQUES, OutputLevel.MOTORS)
PHASES = (0.04, 0.0, 0.08)
"""s after one of PX4's looks at which it dies: as measured on PX4, soonest and latest."""


def main() -> None:
    """Print a table. ``bench.deaths quick``: one death a row."""
    phases = PHASES[:1] if "quick" in sys.argv[1:] else PHASES
    print("| flown in | at | PX4 acts after, s | with | tilt before and most, degrees | lost, m | |")
    print("|---|---|---|---|---|---|---|")
    for levels, own_mode in ((OFFBOARD, False), (OWN_MODE, True)):
        for level in levels:
            found = [death(level, own_mode=own_mode, after_look=phase) for phase in phases]
            took = ", ".join(f"{each.took:.2f}" for each in found)
            tilts = ", ".join(f"{each.tilt_before:.0f} {each.tilt_max:.0f}" for each in found)
            lost, by = max(each.lost for each in found), found[0].mode.words
            end = "crash" if any(each.fell for each in found) else ""
            where = "our mode" if own_mode else "OFFBOARD"
            print(f"| {where} | {level.value} | {took} | {by} | {tilts} | {lost:.2f} | {end} |", flush=True)


if __name__ == "__main__":
    main()
