"""A plan through the command line: without --duration it is flown to its end, and is replayed with its payload."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.test_export import run
from tests.support.plan_text import HOME, item, waypoint, written


def test_a_plan_is_flown_to_its_end_and_replayed(tmp_path: Path) -> None:
    """Heights of both kinds, in a world whose home lies 20 m under the planned one: as high above the sea as it says."""
    world, flown = tmp_path / "low.yaml", tmp_path / "flight"
    world.write_text(
        f"name: low\nhome: {{latitude_deg: {HOME[0]}, longitude_deg: {HOME[1]}, altitude_m: {HOME[2] - 20}}}\n"
    )
    file = written(
        tmp_path / "field.plan", waypoint(0, 0, 30, command=22), waypoint(6, 0, HOME[2] + 10, frame=0), item(203, 0, 0, 0, 0, 1)
    )  # fmt: skip
    code, said = run("sim", str(file), "--world", str(world), "--record", str(flown), "--no-report", "--json")
    assert code == 0, said
    summary = json.loads((flown / "summary.json").read_text())
    assert (summary["outcome"], summary["phases"][-2]["phase"]) == ("completed", "hand back")
    assert "rest" in [phase["phase"] for phase in summary["phases"]]
    assert "the same, bit for bit" in run("replay", str(flown))[1]
