"""The end of an open path: reached, rested at and handed back, whatever the output and the speed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.config.mission.mission import load_mission
from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.feasibility.report import check
from companion.flight.phases import Phase
from companion.law.gains import law_level
from companion.pilot import completed
from companion.vehicle import OutputLevel
from companion.world import World
from companion.world.events import Hold, When
from tests.support.flights import Flown, flight

MISSION = """
mission: to-the-end
frame: enu
path: {path}
speed: {speed}
yaw: tangent
"""
LINE = "{kind: line, from: [0, 0, 10], to: [8, 0, 11]}"
HELIX = "{kind: helix, center: [0, 0, 10], radius: 2, pitch: 1.5, turns: 1}"


def flown_to_the_end(
    tmp_path: Path, level: OutputLevel, path: str, speed: str, world: World, late: float = 2.0
) -> None:
    """Flies it, and looks at where and when it ended."""
    file = tmp_path / "mission.yaml"
    file.write_text(MISSION.format(path=path, speed=speed))
    report = check(load_mission(str(file), law_level(level)), load_vehicle("x500"))
    rested: list[tuple[float, float]] = []

    def meddle(flown: Flown, now: float) -> None:
        memory, plan = flown.conductor.memory, flown.conductor.plan
        if memory is None or plan is None or memory.phase not in (Phase.REST, Phase.HAND_BACK):
            return
        assert memory.state is not None
        assert memory.path.follow_from is not None
        end, _, _ = plan.table.at(plan.table.length if plan.direction > 0.0 else 0.0)
        if memory.phase is Phase.HAND_BACK and not rested:
            rested.append((math.dist(memory.state.p_n, end), memory.state.t_boot - memory.path.follow_from))

    flown = flight(str(file), level=level, duration=None, world=world, time_out=60.0, meddle=meddle)
    assert flown.conductor.memory is not None
    assert completed(flown.conductor.memory), flown.notes
    ((distance, lasted),) = rested
    assert distance < 0.02
    assert -2.0 < lasted - report.duration < late


@pytest.mark.parametrize(
    ("level", "path", "speed"),
    [
        (OutputLevel.RATES, LINE, "{auto: {speed_max: 5}}"),
        (OutputLevel.ATTITUDE, HELIX, "-1.5"),  # its ends lie above each other
        (OutputLevel.RATES, LINE, "{table: [[0, 2.0], [4, 3.0], [8, 1.0]]}"),
        (OutputLevel.MOTORS, LINE, "{auto: {speed_max: 5}}"),
        (OutputLevel.MOTORS, HELIX, "-1.5"),
        (OutputLevel.MOTORS, LINE, "{table: [[0, 2.0], [4, 3.0], [8, 1.0]]}"),
    ],
)
def test_it_is_reached_in_the_time_that_check_foretells(
    tmp_path: Path, level: OutputLevel, path: str, speed: str
) -> None:
    flown_to_the_end(tmp_path, level, path, speed, load_world("sih"))


def test_a_vehicle_that_was_held_before_the_end_reaches_it(tmp_path: Path) -> None:
    """A standstill before the end is no equilibrium, whatever the profile."""
    held = World(events=(Hold(When(5.5, 7.5)),))
    flown_to_the_end(tmp_path, OutputLevel.RATES, LINE, "{auto: {speed_max: 3}}", held, late=5.0)
