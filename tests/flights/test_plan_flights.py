"""Plans from their file to the flight and its replay, in the place where they were drawn."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from companion.cli.check import check_sortie
from companion.cli.finish import COMPLETED, Ending
from companion.cli.new import new
from companion.cli.output import Output
from companion.cli.simulate import Simulation, in_lockstep
from companion.config.examples import PATHS
from companion.library.orders import read_sortie, read_world
from companion.library.simulation import at_home
from companion.mission import GlobalOrigin
from companion.record.replay import load_flight, replay
from companion.world import Home, World
from tests.support.plan_text import HOME, item, waypoint, written


@pytest.mark.parametrize(("output", "from_ground"), [(Output.MOTORS, False), (Output.AUTO, True)])
def test_a_plan_flies_and_is_replayed(tmp_path: Path, output: Output, from_ground: bool) -> None:
    file = written(
        tmp_path / "field.plan", waypoint(0, 0, 8, command=22), waypoint(15, 0, 8), item(178, 1, 2), waypoint(15, 15, 9)
    )
    sortie, found = check_sortie(read_sortie(str(file), None, output, direct=True))
    assert found.feasible
    folder = tmp_path / "flight"
    simulation = Simulation(sortie, read_world("ideal", 0), from_ground, 6.0, folder, Ending(True, 2.0))
    assert in_lockstep(simulation) == COMPLETED
    figures = json.loads((folder / "summary.json").read_text())
    assert figures["truth"]["settled"]["path_error_m"]["max"] < 0.05
    assert (folder / "field.plan").read_text() == file.read_text()
    file.unlink()  # the folder has all it needs
    again = replay(load_flight(folder))
    assert again.difference is None
    assert again.setpoints > 500


@pytest.mark.parametrize("kind", PATHS)
def test_an_example_of_every_kind_flies(kind: str, tmp_path: Path) -> None:
    new(kind, tmp_path / "mine.yaml", force=False)
    sortie = check_sortie(read_sortie(str(tmp_path / "mine.yaml"), None, Output.MOTORS, direct=True))[0]
    folder = tmp_path / "flight"
    assert in_lockstep(Simulation(sortie, read_world("ideal", 0), False, 2.0, folder, Ending(True, 0.5))) == COMPLETED
    figures = json.loads((folder / "summary.json").read_text())
    assert figures["truth"]["settled"]["path_error_m"]["max"] < 0.02


def test_a_world_without_a_place_is_where_the_plan_is(tmp_path: Path) -> None:
    file = written(tmp_path / "field.plan", waypoint(0, 0, 8), waypoint(30, 0, 8))
    mission = read_sortie(str(file), None, Output.AUTO).mission
    assert isinstance(mission.origin, GlobalOrigin)
    placed, world = at_home(mission, World())
    assert (world.home.latitude, world.home.longitude) == HOME[:2]
    assert placed.table.at(0.0)[0] == pytest.approx((0.0, 0.0, -8.0), abs=1e-6)
    elsewhere = World(home=Home(HOME[0] - 0.001, HOME[1], 300.0))
    placed, world = at_home(mission, elsewhere)
    assert world is elsewhere
    assert placed.table.at(0.0)[0] == pytest.approx((111.19, 0.0, -8.0), abs=0.01)
