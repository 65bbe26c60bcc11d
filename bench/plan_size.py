"""A plan of ten thousand waypoints: seconds to load it, and a step of the law there against one at ten waypoints."""

from __future__ import annotations

import json
import random
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.frames import rotation_from_euler
from companion.law.feedback import Bounds
from companion.law.flight import CurveLaw, Flying, curve_law, model_of
from companion.law.gains import Level, default_gains
from companion.law.speed_scale import SpeedScale
from companion.mission import Mission
from companion.paths.curve import Curve
from companion.profiles import ConstantSpeed

HOME = (47.397742, 8.545594, 488.0)
LANE, APART = 6.0, 3.0
"""m, the length of a survey's lanes and their distance."""
BUDGET = 1.2
STEPS, ROUNDS = 4000, 15


def survey(count: int) -> str:
    """A plan of ``count`` waypoints, up and down short lanes, as QGroundControl writes it."""
    items: list[dict[str, Any]] = []
    for i in range(count):
        north, east = LANE * ((i + 1) // 2 % 2), APART * (i // 2)
        place = [HOME[0] + north / 111194.93, HOME[1] + east / 75270.0, 25.0]
        items.append(
            {"type": "SimpleItem", "command": 16, "frame": 3, "doJumpId": i + 1, "autoContinue": True,
             "AltitudeMode": 1, "Altitude": 25.0, "AMSLAltAboveTerrain": None, "params": [0, 0, 0, None, *place]}
        )  # fmt: skip
    mission = {"version": 2, "items": items, "plannedHomePosition": HOME, "hoverSpeed": 5, "firmwareType": 12}
    return json.dumps({"fileType": "Plan", "version": 1, "mission": mission}, indent=4)


def loaded(count: int) -> Mission:
    """The mission of such a plan; prints how long it took."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "survey.plan"
        file.write_text(survey(count))
        wall, cpu = time.perf_counter(), time.process_time()
        mission = load_mission(str(file), Level.MOTORS)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"{count:6} waypoints, {mission.table.length / 1000:.2f} km: loaded in {wall:.2f} s ({cpu:.2f} s of a core)")
    return mission


def law_of(mission: Mission) -> CurveLaw:
    """The law at motors along its path."""
    assert isinstance(mission.path, Curve)
    gains = default_gains(Level.MOTORS)
    model = model_of(load_vehicle("x500"))
    return curve_law(mission.path, ConstantSpeed(3.0), mission.yaw, Level.MOTORS, model, gains, Bounds(), 1.0)


def states(mission: Mission, count: int) -> list[Flying]:
    """States near the path, all along it."""
    rng = random.Random(1)
    r_nb = rotation_from_euler(0.1, 0.1, -0.1)
    found = []
    for i in range(count):
        s = mission.table.length * i / count
        x, y, z = mission.table.at(s)[0]
        near = (x + rng.uniform(-0.2, 0.2), y + rng.uniform(-0.2, 0.2), z + rng.uniform(-0.2, 0.2))
        found.append(Flying(near, (2.0, 1.0, 0.1), r_nb, 19.0, (0.1, 0.0, 0.1), 0.5, drag=0.2, s=s))
    return found


def step_time(law: CurveLaw, flying: list[Flying]) -> float:
    """us a step."""
    ramp = SpeedScale()
    begun = time.perf_counter()
    for state in flying:
        law(state, ramp)
    return (time.perf_counter() - begun) / len(flying) * 1e6


def main() -> None:
    """Print the figures; exit code 1 where a step costs more than the budget."""
    small, large = loaded(10), loaded(10_000)
    laws, flying = [law_of(small), law_of(large)], [states(small, STEPS), states(large, STEPS)]
    times = [[step_time(law, f) for law, f in zip(laws, flying, strict=True)] for _ in range(ROUNDS)]
    ratio = statistics.median(b / a for a, b in times)
    best = [min(column) for column in zip(*times, strict=True)]
    print(f"a step of the law: {best[0]:.1f} us at 10, {best[1]:.1f} us at 10 000 waypoints")
    print(f"median of the ratios: {ratio:.3f}, at most {BUDGET}")
    raise SystemExit(ratio > BUDGET)


if __name__ == "__main__":
    main()
