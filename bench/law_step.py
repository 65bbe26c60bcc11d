"""Time of one step of the law, in microseconds: straight-line code against the same arithmetic on Taylor objects."""

from __future__ import annotations

import timeit

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.frames import rotation_from_euler
from companion.law.feedback import Bounds
from companion.law.flight import Flying, implicit_law, model_of
from companion.law.gains import Level, default_gains
from companion.law.speed_scale import SpeedScale

BUDGET_US = 25.0


def main() -> None:
    """Print the table."""
    vehicle = load_vehicle("x500")
    r_nb = rotation_from_euler(0.1, 0.1, -0.1)
    flying = Flying((0.3, 5.2, -10.1), (2.9, 0.1, 0.0), r_nb, 19.0, (0.1, 0.0, 0.1), 0.5, drag=0.2)
    ramp = SpeedScale()
    print("level    bounds  us a step (best of 7)")
    for level in Level:
        mission = load_mission("circle_r5", level)
        for bounds in (None, Bounds()):
            law = implicit_law(mission.specification(1.0), level, model_of(vehicle), default_gains(level), bounds)
            number = 5000

            def step(law: object = law) -> None:
                law(flying, ramp)  # type: ignore[operator]

            best = min(timeit.repeat(step, number=number, repeat=7)) / number * 1e6
            print(
                f"{level.name.lower():8} {'yes' if bounds else 'no':6}  {best:6.1f}   (budget at motors: {BUDGET_US:g})"
            )


if __name__ == "__main__":
    main()
