"""What `companion fly` refuses before it listens for a vehicle."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.vehicle import CompanionError


@pytest.mark.parametrize(
    ("output", "says"),
    [("torques", "torques go over XRCE alone; give --xrce"), ("motors", "its file says motors: px4")],
)
def test_a_level_that_cannot_reach_the_vehicle_is_refused_at_once(output: str, says: str) -> None:
    told = CliRunner().invoke(app, ["fly", "circle_r5", "--output", output, "--connect", "udpin://127.0.0.1:14999"])
    assert isinstance(told.exception, CompanionError)  # which ends the command with 2
    assert says in str(told.exception)
