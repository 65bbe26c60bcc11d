"""What is shipped flies as well as it should as it is shipped: `companion sim NAME`, without an option."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from companion.cli.commands import app

FLOWN = {
    "ellipse": 24.0, "figure8": 26.0, "lissajous": 26.0, "polyline": 30.0, "spline": 26.0, "line": 40.0,
    "paper_case1": 14.0,
}  # fmt: skip
"""s of following: the missions that turn, lean and change their speed most, an open one, and one at its own output. All
of them, for as long as they last: `companion sim NAME --json`."""


@pytest.mark.parametrize("name", FLOWN)
def test_a_shipped_mission_settles_as_it_is_shipped(name: str) -> None:
    """Path error below 1 cm, speed error below 2 % of alpha, yaw error below 1 degree (the last two RMS)."""
    result = CliRunner().invoke(app, ["sim", name, "--duration", str(FLOWN[name]), "--json"])
    assert result.exit_code == 0, result.output
    flight = json.loads(result.stdout)
    assert flight["outcome"] == "completed"
    for settled in (flight["settled"], flight["truth"]["settled"]):
        mean = settled["distance_m"] / settled["duration_s"]
        assert settled["path_error_m"]["max"] < 0.01
        assert settled["speed_error_mps"]["rms"] < 0.02 * mean
        assert settled["yaw_error_deg"]["rms"] < 1.0


@pytest.mark.parametrize(("seed", "output"), [(2, "rates"), (10, "rates"), (2, "motors")])
def test_the_storm_is_flown_in(seed: int, output: str) -> None:
    """The thrust is known within four seconds of its gusts, and the circle is held to half a metre."""
    result = CliRunner().invoke(
        app,
        [
            "sim",
            "circle",
            "--world",
            "storm",
            "--output",
            output,
            "--seed",
            str(seed),
            "--duration",
            "6",
            "--settle",
            "3",
            "--json",
        ],
    )
    assert result.exit_code == 0, result.output
    flight = json.loads(result.stdout)
    assert flight["outcome"] == "completed"
    (settled,) = [phase for phase in flight["phases"] if phase["phase"] == "settle"]
    assert settled["to_s"] - settled["from_s"] < 4.0
    assert flight["settled"]["path_error_m"]["max"] < 0.5
