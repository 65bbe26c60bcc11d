"""circle_r5 at motors and torques over XRCE beside rates over MAVLink, on the stand-in's PX4 and the vehicle sih.

    python -m bench.xrce_circle [world ...]

At 3, 5 and 7 m/s, in still air with PX4's estimate (world sih) and with its sensors' noise (sih_noisy). The path error
is the vehicle's own, root mean square from 8 s after the first setpoint on. Target: at most 1.5 times that of rates.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from companion.daemon.conductor import Conductor
from companion.library.lockstep import fly
from companion.vehicle import OutputLevel
from sim_bridge.plant import Truth
from trials.deaths import placed

SPEEDS = (3.0, 5.0, 7.0)
LEVELS = (OutputLevel.RATES, OutputLevel.MOTORS, OutputLevel.TORQUES)
SETTLED, DURATION, TIME_OUT = 8.0, 14.0, 60.0
TARGET = 1.5


def path_error(level: OutputLevel, world: str, speed: float) -> float:
    """m, root mean square."""
    bridge, conductor = placed(level, own_mode=False, duration=DURATION, speed=speed, world=world)
    errors: list[float] = []
    begun = math.inf

    def watch(conductor: Conductor, truth: Truth) -> None:
        nonlocal begun
        last = conductor.last
        if last is None or last.now != bridge.now or last.outcome.setpoint is None:
            return
        begun = min(begun, bridge.now)
        if bridge.now - begun > SETTLED and last.memory.path.progress is not None:
            errors.append(last.memory.path.progress.path_error)

    fly(conductor, bridge, watch, TIME_OUT)
    if len(errors) < 300:
        raise SystemExit(
            f"{level.value} at {speed:g} m/s in {world}: not flown: {conductor.refusal or conductor.notes}"
        )
    return math.sqrt(sum(error * error for error in errors) / len(errors))


def main() -> None:
    """Print a table."""
    held = True
    print(
        "| world | m/s | rates over MAVLink, cm | motors over XRCE, cm | torques over XRCE, cm |\n|---|---|---|---|---|"
    )
    for world in sys.argv[1:] or ("sih", "sih_noisy"):
        for speed in SPEEDS:
            by_rates, *others = (path_error(level, world, speed) for level in LEVELS)
            held = held and all(error <= TARGET * by_rates for error in others)
            cells = " | ".join(f"{100 * error:.1f} ({error / by_rates:.2f})" for error in others)
            print(f"| {world} | {speed:g} | {100 * by_rates:.1f} | {cells} |", flush=True)
    print(f"target {TARGET:g} times: {'held' if held else 'MISSED'}")
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
