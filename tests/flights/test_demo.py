"""The demo: begins off the path at the wrong speed, is held still and let go, and says so in words and figures."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app


class Shown(NamedTuple):
    figures: dict
    said: str
    directory: Path


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Shown:
    directory = tmp_path_factory.mktemp("demo") / "flight"
    result = CliRunner().invoke(app, ["demo", "--fast", "--json", "--record", str(directory)])
    assert result.exit_code == 0, result.output
    return Shown(json.loads(result.stdout), result.stderr, directory)


def event(shown: Shown, kind: str) -> dict[str, Any]:
    """The one event of a kind."""
    (only,) = (event for event in shown.figures["events"] if event["kind"] == kind)
    return only


def test_it_comes_back_twice_and_never_chases(shown: Shown) -> None:
    start, hold = event(shown, "start"), event(shown, "hold")
    assert (start["kind"], hold["kind"]) == ("start", "hold")
    assert start["path_error_max_m"] == pytest.approx(2.0, abs=0.01) and start["back_after_s"] < 4.0
    assert hold["to_s"] - hold["from_s"] == pytest.approx(3.0, abs=0.02)
    assert hold["timetable_ahead_m"] == pytest.approx(9.0, abs=0.2)
    assert hold["back_after_s"] < 4.0 and hold["path_error_max_m"] < 0.15 and hold["speed_max_mps"] < 3.3


def test_the_event_is_where_the_truth_has_it(shown: Shown) -> None:
    """The times of an event are found again from the record: the plant's own say the same."""
    truth, hold = np.load(shown.directory / "truth.npy"), event(shown, "hold")
    still = truth["t_boot"][np.flatnonzero(np.linalg.norm(truth["v_n"], axis=1) == 0.0)]
    flight = np.load(shown.directory / "flight.npy")
    first = flight["t_boot"][np.flatnonzero(np.isfinite(flight["alpha"]))[0]]
    assert hold["from_s"] == pytest.approx(still[0] - first, abs=0.03)
    assert hold["to_s"] == pytest.approx(still[-1] - first, abs=0.03)


def test_it_tells_what_happens_in_words(shown: Shown) -> None:
    in_order = [
        "A controller that follows a timetable", "world demo: wind 1.1 m/s from the south-west", "begins 2.0 m off the path",
        "on the path at", "held still for 3 s", "let go: a timetable would be 9.0 m ahead", "on the path at",
    ]  # fmt: skip
    assert re.search(".*".join(map(re.escape, in_order)), shown.said, re.DOTALL), shown.said


def test_where_it_was_flown_is_in_the_summary(shown: Shown) -> None:
    simulation = shown.figures["simulation"]
    assert (simulation["world"], simulation["seed"]) == ("demo", 0)
    assert shown.figures["version"]
    assert (shown.directory / "world.yaml").is_file() and (shown.directory / "report.html").is_file()


def test_plain_is_the_undisturbed_circle(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["demo", "--fast", "--plain", "--json", "--record", str(tmp_path / "flight")])
    assert result.exit_code == 0, result.output
    figures = json.loads(result.stdout)
    assert figures["mission"] == "circle-r10" and figures["events"] == []
    assert figures["settled"]["path_error_m"]["max"] < 0.001
