"""circle_r5 at motors and torques over XRCE beside rates over MAVLink, on the stand-in's PX4 and the vehicle sih.

    python -m bench.xrce_circle [seeds [world ...]]

At 3, 5 and 7 m/s, in still air with PX4's estimate (world sih) and with its sensors' noise (sih_noisy). The path error
is the vehicle's own, root mean square from 8 s after the first setpoint on, over so many seeds of the world (1).
Target: at most 1.3 times that of rates.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from companion.vehicle import OutputLevel
from trials.xrce_circle import path_error

SPEEDS = (3.0, 5.0, 7.0)
LEVELS = (OutputLevel.RATES, OutputLevel.MOTORS, OutputLevel.TORQUES)
TARGET = 1.3


def over_seeds(level: OutputLevel, world: str, speed: float, seeds: int) -> float:
    """m, root mean square."""
    return math.sqrt(sum(path_error(level, world, speed, seed) ** 2 for seed in range(seeds)) / seeds)


def main() -> None:
    """Print a table."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    held = True
    print(
        "| world | m/s | rates over MAVLink, cm | motors over XRCE, cm | torques over XRCE, cm |\n|---|---|---|---|---|"
    )
    for world in sys.argv[2:] or ("sih", "sih_noisy"):
        for speed in SPEEDS:
            by_rates, *others = (over_seeds(level, world, speed, seeds) for level in LEVELS)
            held = held and all(error <= TARGET * by_rates for error in others)
            cells = " | ".join(f"{100 * error:.1f} ({error / by_rates:.2f})" for error in others)
            print(f"| {world} | {speed:g} | {100 * by_rates:.1f} | {cells} |", flush=True)
    print(f"target {TARGET:g} times: {'held' if held else 'MISSED'}")
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
