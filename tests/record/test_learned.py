"""What a flight leaves for the next: believed while fresh, bounded, and kept in a file that may be anything."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.estimation.estimator import DRAG_STD, THRUST_SCALE_STD
from companion.estimation.learned import AGEING, Learned, prior_of, sane
from companion.record.learned import load_learned, save_learned, state_file
from companion.vehicle import OutputLevel
from trials.measured import course, machine, measure_flight, world

FOUND = Learned(0.5, 0.8, 0.065)


def test_fresh_figures_replace_what_was_told() -> None:
    prior = prior_of(FOUND, 0.6, 0.1)
    assert prior.thrust_scale[0] == pytest.approx(1.2)  # told 0.6, truly 0.5: every newton asked for gives 1.2
    assert prior.drag[0] == pytest.approx(0.8)
    assert prior.thrust_scale[1] < THRUST_SCALE_STD
    assert prior.drag[1] < DRAG_STD


def test_what_was_hardly_known_is_believed_less_and_stays_near_the_file() -> None:
    sure, unsure = (prior_of(FOUND._replace(drag_std=std, hover_thrust_std=0.5 * std), 0.6, 0.1) for std in (0.02, 0.4))
    assert sure.drag[1] < unsure.drag[1] <= DRAG_STD
    assert 0.1 < unsure.drag[0] < sure.drag[0] <= 0.8
    assert sure.thrust_scale[1] < unsure.thrust_scale[1] <= THRUST_SCALE_STD
    assert 1.0 < unsure.thrust_scale[0] < sure.thrust_scale[0] <= 1.2


def test_a_file_of_before_deviations_were_kept_is_still_read(tmp_path: Path) -> None:
    file = tmp_path / "quad.json"
    file.write_text('{"hover_thrust": 0.5, "drag_per_s": 0.8, "rate_loop_lag_s": 0.065, "flown_at": 1.0}')
    old = load_learned(file)
    assert old is not None
    assert (old.hover_thrust_std, old.drag_std) == (0.0, 0.0)


def test_old_figures_are_doubted_as_if_never_flown() -> None:
    prior = prior_of(FOUND._replace(age_days=2.0 * AGEING), 0.6, 0.1)
    assert prior.thrust_scale[1] == pytest.approx(THRUST_SCALE_STD)
    assert prior.drag == pytest.approx((0.1, DRAG_STD))


@pytest.mark.parametrize(
    "wrong",
    [
        {"hover_thrust": 0.0},
        {"drag": -1.0},
        {"rate_lag": math.nan},
        {"age_days": -1.0},
        {"drag": math.inf},
        {"yaw_lag": 9.0},
    ],
)
def test_what_no_vehicle_can_be_is_not_believed(wrong: dict[str, float]) -> None:
    assert not sane(FOUND._replace(**wrong))
    assert prior_of(FOUND._replace(**wrong), 0.6, 0.1) == prior_of(None, 0.6, 0.1)


def test_kept_and_recalled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    file = state_file("my quad/../x")
    assert file.parent == tmp_path / "companion"
    assert load_learned(file) is None
    found = FOUND._replace(hover_thrust_std=0.004, drag_std=0.03)
    assert save_learned(file, found)
    again = load_learned(file)
    assert again is not None
    assert again[:3] == found[:3]
    assert again[4:] == found[4:]
    assert again.age_days < 0.1


@pytest.mark.parametrize("text", ["", "{", "[]", '{"hover_thrust": "x"}', '{"hover_thrust": 7, "drag_per_s": 0}'])
def test_a_spoiled_file_is_as_good_as_none(tmp_path: Path, text: str) -> None:
    file = tmp_path / "quad.json"
    file.write_text(text)
    assert load_learned(file) is None


def test_a_place_that_cannot_be_written_is_no_fault(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert not save_learned(tmp_path / "file" / "quad.json", FOUND)


def test_a_flight_finds_out_what_its_vehicle_is() -> None:
    done = measure_flight(course("circle_r5", 3.0), machine("x500"), world("ideal"), OutputLevel.RATES, duration=17.0)
    learned = done.conductor.learned
    assert learned is not None
    assert learned.hover_thrust == pytest.approx(0.5737, rel=0.02)
    assert learned.drag == pytest.approx(0.2, abs=0.02)
    assert 0.0 < learned.hover_thrust_std < 0.02
    assert 0.0 < learned.drag_std < 0.1


def test_what_is_learned_is_shown_beside_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    runner = CliRunner()
    told = runner.invoke(app, ["vehicle", "show", "x500"])
    assert told.exit_code == 0 and "nothing is learned of it yet" in told.output
    file = state_file("x500")
    assert file is not None
    assert save_learned(file, Learned(0.54, 0.35, 0.055, 0.0, 0.004, 0.02, 0.31))
    told = runner.invoke(app, ["vehicle", "show", "x500"])
    assert (
        "0.54 +- 0.004" in told.output
        and "0.35 +- 0.02" in told.output
        and "0.31" in told.output
        and "learned 0.0 days ago" in told.output
    )
    figures = json.loads(runner.invoke(app, ["vehicle", "show", "x500", "--json"]).output)["figures"]
    hover = next(row for row in figures if row["key"] == "hover thrust")
    assert hover["told"] == 0.57 and hover["believed"] == pytest.approx(0.54, rel=0.02)
    assert hover["believed_std"] > hover["learned_std"]  # another battery, load or propeller
