"""Studies: the file with all its mistakes, the draws, the results that a kill leaves whole, the engine, the verdict."""

from __future__ import annotations

import csv
import functools
import json
import math
import os
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.config.study.keys import RequireModel, StudyModel, VaryModel
from companion.config.syntax.faults import ConfigError
from companion.daemon.conductor import Conductor
from companion.flight.phases import Phase
from companion.library.files import VehicleFile, WorldFile
from companion.study.engine import flown
from companion.study.explaining import ERRORS, sobol_indices
from companion.study.flying import Case, asked_of, cases_of, row_of
from companion.study.reading import load_study, study_from
from companion.study.results import Results, load_rows, load_run_study
from companion.study.sampling import ends_of, quantile, samples
from companion.study.stored import at_hand
from companion.study.telling import in_words, judged, rate_of, shown, worst

ROOT = Path(__file__).resolve().parents[2]
TINY = """\
study: tiny
mission: circle_r5
vehicle: x500
world: outdoor
duration: 1.5
settle: 0.5
flights: 2
seed: 3
vary:
  world.truth.mass_kg: {uniform: [1.8, 2.2]}
require:
  truth.settled.path_error_m.rms: {max: 0.5}
"""
WRONG = """\
study: wrong
mission: circle_r6
vehicle: x500
world: outdoor
output: rate
duration: 0
settel: 3
vary:
  world.truth.mas_kg: {uniform: [1, 2]}
  world.truth.mass_kg: {uniform: [2, 1]}
  wind: {choice: [1]}
  vehicle.mass_kg: {uniform: [2.0, 90]}
require:
  truth.settled.path_eror_m.rms: {max: 1}
  settled.path_error_m.max: {}
"""


def test_ten_mistakes_are_ten_lines_and_nothing_is_started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wrong.yaml").write_text(WRONG, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["study", "run", "wrong.yaml"])
    assert isinstance(result.exception, ConfigError)
    lines = str(result.exception).splitlines()
    said = {int(line.split(":")[1]): line for line in lines}
    assert len(lines) == 10 and set(said) == {2, 5, 6, 7, 9, 10, 11, 12, 14, 15}
    assert "did you mean circle_r5" in said[2] and "did you mean settle?" in said[7]
    assert "vary.world.truth.mas_kg" in said[9] and "does not rise" in said[10] and "weighs" in said[12]
    assert "did you mean truth.settled.path_error_m.rms?" in said[14]
    assert list(tmp_path.iterdir()) == [tmp_path / "wrong.yaml"]


@pytest.mark.parametrize("file", sorted((ROOT / "configs/studies").glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_studies_can_be_run(file: Path) -> None:
    """Their first flights, 2 s of each."""
    cases = cases_of(load_study(file))
    assert len(cases) >= 100
    row = row_of(replace(cases[0], duration=2.0, settle=1.0))
    assert row["outcome"] == "completed", row["reason"]
    assert row["truth.settled.path_error_m.rms"] < 1.0
    assert row["truth.flight.impact_mps"] < 1.0  # one of them lands


def test_a_flight_in_which_the_companion_itself_failed_never_passes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not where giving up in order is an answer either; and it is told the same by its replay, whose folder stays."""
    (case,) = cases_of(study_from(FAILING, "failing.yaml"))
    really = Conductor.on_timer

    def failing(conductor: Conductor, now: float) -> None:
        if conductor.memory is not None and conductor.memory.phase is Phase.FOLLOW:
            raise ZeroDivisionError("no such thing")
        really(conductor, now)

    monkeypatch.setattr(Conductor, "on_timer", failing)
    row, again = row_of(case), row_of(case, tmp_path / "folder")
    assert row["outcome"] == "failed" and not row["passed"]
    assert "the companion itself failed (ZeroDivisionError: no such thing" in row["reason"]
    assert {**row, "wall_s": 0.0} == {**again, "wall_s": 0.0}
    assert "ZeroDivisionError" in (tmp_path / "folder" / "failure.txt").read_text()


FAILING = """\
study: failing
mission: circle_r5
duration: 1
settle: 0
completed: false
"""


def test_every_combination_of_a_grid_is_flown_at_the_same_draws() -> None:
    vary = {"a": VaryModel(choice=["p", "q"]), "b": VaryModel(uniform=[2.0, 4.0]), "c": VaryModel(range=[0.0, 1.0, 3])}
    made = samples(vary, 48, "sobol", 1)
    assert {(row["a"], row["c"]) for row in made} == {(a, c) for a in "pq" for c in (0.0, 0.5, 1.0)}
    drawn = {key: [row["b"] for row in made if row["a"] == key] for key in "pq"}
    assert drawn["p"] == drawn["q"] and 2.0 <= min(drawn["p"]) < 2.5 and 3.5 < max(drawn["p"]) <= 4.0
    assert made == samples(vary, 48, "sobol", 1) != samples(vary, 48, "sobol", 2)


@pytest.mark.parametrize("sampling", ["sobol", "latin", "random"])
def test_draws_have_the_distributions_they_are_called_by(sampling: str) -> None:
    vary = {
        "n": VaryModel(normal=[5.0, 2.0]),
        "w": VaryModel(weibull=[4.0, 2.0]),
        "l": VaryModel(loguniform=[1.0, 100.0]),
    }
    made = samples(vary, 2048, sampling, 7)
    normal, weibull, logs = (np.array([row[name] for row in made]) for name in "nwl")
    assert normal.mean() == pytest.approx(5.0, abs=0.2) and normal.std() == pytest.approx(2.0, abs=0.15)
    assert weibull.mean() == pytest.approx(4.0 * 0.8862, rel=0.04)
    assert np.median(logs) == pytest.approx(10.0, rel=0.15)
    assert ends_of(vary["l"]) == [1.0, 100.0] and quantile(vary["n"], 0.0) > -10.0


def test_the_bounds_of_a_rate_are_exact() -> None:
    assert rate_of(100, 100, 0.95)[2:] == pytest.approx((0.025**0.01, 1.0))  # p^100 = 0.025
    assert rate_of(0, 10, 0.9)[2:] == pytest.approx((0.0, 1.0 - 0.05**0.1))
    low, high = rate_of(8, 10, 0.95)[2:]
    assert (low, high) == pytest.approx((0.44390, 0.97479), abs=1e-5)  # R: binom.test(8, 10)


def rows(count: int = 20) -> list[dict[str, Any]]:
    name = "truth.settled.path_error_m.rms"
    return [
        {"index": i, "passed": i != 4, "outcome": "completed", "vary.mass": float(i), "vary.kind": "x", name: 0.01 * (i + 1)}
        for i in range(count)
    ]  # fmt: skip


def test_the_verdict_the_worst_and_what_explains_them() -> None:
    model = StudyModel(study="s", mission="m", pass_rate=0.95, vary={"mass": VaryModel(uniform=[0.0, 20.0])})
    said = judged(model, rows(), 20)
    assert said.holds and not judged(model, rows(), 21).holds
    assert not judged(model.model_copy(update={"pass_rate": 0.96}), rows(), 20).holds
    assert [row["index"] for row in worst(model, rows(), 3)] == [4, 19, 18]
    lost = {"index": 7, "passed": False, "outcome": "aborted", "reason": "no state"}  # before it had an error
    assert [row["index"] for row in worst(model, [*rows()[:7], lost, *rows()[8:]], 3)] == [7, 4, 19]
    believed = [{**row, "settled.path_error_m.rms": -row["index"]} for row in rows()]
    asked = model.model_copy(update={"require": {"settled.path_error_m.rms": RequireModel(max=1.0)}})
    assert [row["index"] for row in worst(asked, believed, 3)] == [
        4,
        0,
        1,
    ]  # what is required is what they are ranked by
    ((key, rank),) = said.ranks
    assert key == "mass" and rank == pytest.approx(1.0)
    assert in_words(said)[0].startswith("s holds: 19 of 20 flights passed (95.0 %)")
    assert "1 of 21 flights are still to be flown: --resume" in in_words(judged(model, rows(), 21))


def test_a_value_is_shown_as_the_file_has_it() -> None:
    assert shown([{"kind": "push", "force_n": [8, 0.123456, 0]}]) == "[{kind: push, force_n: [8, 0.1235, 0]}]"


def test_sobol_indices_are_those_of_ishigami() -> None:
    """Ishigami's function with a = 7, b = 0.1: S = 0.314, 0.442, 0; total 0.558, 0.442, 0.244."""
    uniform = VaryModel(uniform=[-math.pi, math.pi])
    vary = {"z": uniform, "kind": VaryModel(choice=[-1.0, 1.0]), "x": uniform, "y": uniform}
    model = StudyModel(study="s", mission="m", sampling="saltelli", vary=vary, flights=2 * 5 * 1024)
    made = [
        {"index": i, ERRORS[0]: math.sin(v["x"]) * (1.0 + 0.1 * v["z"] ** 4) + 7.0 * math.sin(v["y"]) ** 2 + v["kind"]}
        for i, v in enumerate(samples(vary, 2 * 5 * 1024, "saltelli", 3))
    ]
    found = sobol_indices(model, made, len(made))
    assert found is not None and [i.name for i in found] == ["y", "x", "z"]
    assert [i.first for i in found] == pytest.approx([0.442, 0.314, 0.0], abs=0.03)
    assert [i.total for i in found] == pytest.approx([0.442, 0.558, 0.244], abs=0.03)
    assert sobol_indices(model, made[:-1], len(made)) is None
    assert sobol_indices(model.model_copy(update={"sampling": "sobol"}), made, len(made)) is None


def test_formulas_are_made_of_names_of_ones_own() -> None:
    text = TINY.replace("  world.truth.mass_kg: {uniform: [1.8, 2.2]}\n", FORMULAS)
    cases = cases_of(study_from(text, "tiny.yaml"))
    for case in cases:
        mass, told = case.varied["mass"], case.varied["told"]
        assert case.varied["world.truth.mass_kg"] == mass and case.varied["vehicle.mass_kg"] == mass * told
        assert case.varied["world.truth.inertia_kgm2"] == [0.01 * mass, 0.01 * mass, 0.02 * mass]
        # a light frame with these rotors or a heavy one with those cannot be read, but nobody flies it
        asked = asked_of(case, case.mission)
        vehicle, world = asked.vehicle, asked.world
        assert isinstance(vehicle, VehicleFile) and vehicle.value.mass == pytest.approx(mass * told)
        assert isinstance(world, WorldFile) and world.value.truth.mass == mass and "mass" not in world.data
    wrong = text.replace("mass*told}", "mass*tld}").replace("formula: mass}", "formula: 1/(mass - 0.6)}")
    with pytest.raises(ConfigError) as found:
        study_from(wrong, "tiny.yaml")
    said = str(found.value)
    assert "'tld' is unknown here; expected one of mass, told, pi" in said and "makes no number" in said
    assert "told: is not known" in said and "a name that a formula uses" in said
    assert said.count("makes no number") == 1  # and not once for every formula beside it
    part = text.replace("mass*told", "mass").replace("  told:", "  tol:").replace("5*mass", "5*mass*total")
    part = part.replace("  mass: {log", "  total: {uniform: [0.9, 1.1]}\n  mass: {log")
    with pytest.raises(ConfigError, match=r"vary\.tol: is not known"):  # a part of a name is not the name
        study_from(part, "tiny.yaml")
    heavy = text.replace("{formula: mass*told}", "{formula: 100*mass*told}")
    with pytest.raises(ConfigError) as found:
        study_from(heavy, "tiny.yaml")
    assert len(found.value.faults) == 1, found.value


FORMULAS = """\
  mass: {loguniform: [0.6, 3.5]}
  told: {uniform: [0.95, 1.05]}
  world.truth.mass_kg: {formula: mass}
  world.truth.inertia_kgm2: {formula: [0.01*mass, 0.01*mass, 0.02*mass]}
  vehicle.mass_kg: {formula: mass*told}
  vehicle.rotors[0].thrust_max_n: {formula: 5*mass}
  vehicle.rotors[1].thrust_max_n: {formula: 5*mass}
  vehicle.rotors[2].thrust_max_n: {formula: 5*mass}
  vehicle.rotors[3].thrust_max_n: {formula: 5*mass}
"""


def test_a_design_has_whole_blocks() -> None:
    text = TINY + "sampling: saltelli\n"
    with pytest.raises(ConfigError, match="2 flights are no whole design of 1 draws; expected 3"):
        study_from(text, "tiny.yaml")
    assert study_from(text.replace("flights: 2\n", ""), "tiny.yaml").flights == 192  # 3 x 2^6


def test_a_kill_leaves_whole_rows_and_nothing_is_flown_twice(tmp_path: Path) -> None:
    study = study_from(TINY, "tiny.yaml")
    first = Results(tmp_path / "r", study, resume=False)
    assert first.add(rows()[1]) and not first.add(rows()[1])
    with pytest.raises(ConfigError, match="is being written by another companion"):
        Results(tmp_path / "r", study, resume=True)
    first._file.close()  # as a kill does it: no table
    with (tmp_path / "r" / "rows.jsonl").open("a") as log:
        log.write('{"index": 0, "pas')
    with pytest.raises(ConfigError, match="is not empty"):
        Results(tmp_path / "r", study, resume=False)
    with pytest.raises(ConfigError, match="holds another study"):
        Results(tmp_path / "r", study_from(TINY + "pass_rate: 0.5\n", "tiny.yaml"), resume=True)
    again = Results(tmp_path / "r", study, resume=True)
    assert list(again.rows) == [1]
    assert again.add(rows()[0])
    again.close()
    assert [row["index"] for row in load_rows(tmp_path / "r")] == [0, 1]
    with (tmp_path / "r" / "results.csv").open() as file:
        assert [row["vary.mass"] for row in csv.DictReader(file)] == ["0.0", "1.0"]
    parquet = pytest.importorskip("pyarrow.parquet")
    assert parquet.read_table(tmp_path / "r" / "results.parquet").to_pylist()[1]["vary.mass"] == 1.0


def test_the_files_of_a_study_stay_as_they_were(tmp_path: Path) -> None:
    heavy = VehicleFile.load("x500").changed({"mass_kg": 2.3}).save(tmp_path / "heavy.yaml")
    text = TINY.replace("flights: 2", "flights: 4").replace(
        "vary:", "vary:\n  vehicle: {choice: [x500, heavy.yaml]}\n  mission: {choice: [circle_r5, survey]}"
    )
    study = study_from(text, str(tmp_path / "tiny.yaml"))
    Results(tmp_path / "r", study, resume=False).close()
    heavy.unlink()
    again = load_run_study(tmp_path / "r")
    assert cases_of(again) == cases_of(study)
    assert {case.vehicle.value.mass for case in cases_of(again)} == {2.0, 2.3}
    for mission in {case.mission.source.name: case.mission for case in cases_of(again)}.values():
        elsewhere = replace(mission, source=replace(mission.source, name=f"/nowhere/{Path(mission.source.name).name}"))
        with at_hand(elsewhere) as there:
            assert there.length == mission.length
    (tmp_path / "r" / "files.json").write_text('{"schema": "companion.study/1", "files": []}')
    with pytest.raises(ConfigError, match="expected the folder of a study that was run"):
        load_run_study(tmp_path / "r")


def die_once(marker: Path, case: Case) -> dict[str, Any]:
    """What flies in a worker that dies of its third flight, the first time."""
    if case.index == 2 and not marker.exists():
        marker.touch()
        os._exit(9)
    if case.index == 3:
        raise ValueError("no such thing")
    return {"index": case.index, "passed": True}


def test_a_worker_that_dies_loses_no_flight(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    study = study_from(TINY.replace("flights: 2", "flights: 6"), "tiny.yaml")
    landed: list[dict[str, Any]] = []
    flown(cases_of(study), 1, None, landed.append, functools.partial(die_once, tmp_path / "died"))
    assert sorted(row["index"] for row in landed) == list(range(6)) and (tmp_path / "died").exists()
    (failed,) = [row for row in landed if not row["passed"]]
    assert failed["index"] == 3 and failed["reason"] == "ValueError: no such thing"


def test_a_study_is_flown_told_and_flown_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tiny.yaml").write_text(TINY, encoding="utf-8")

    def here(cases: list[Case], workers: int, scheduler: str | None, take: Any) -> None:
        for case in cases:
            take(row_of(case))

    monkeypatch.setattr("companion.study.engine.flown", here)
    run = CliRunner().invoke(app, ["study", "run", "tiny.yaml", "--record", "r"])
    assert run.exit_code == 0, run.output
    assert run.stdout.startswith(
        "tiny holds: 2 of 2 flights passed (100.0 %); the true rate lies between 15.8 and 100.0 %"
    )
    first, second = load_rows(Path("r"))
    assert (first["seed"], second["seed"]) == (3, 4) and 1.8 <= first["vary.world.truth.mass_kg"] <= 2.2
    assert first["truth.settled.path_error_m.rms"] != second["truth.settled.path_error_m.rms"]
    again = CliRunner().invoke(app, ["study", "replay", "r", "1"])
    assert again.exit_code == 0 and "the same figures, bit for bit" in again.stdout
    assert (
        json.loads(Path("r/flights/1/summary.json").read_text())["truth"]["settled"]["path_error_m"]["rms"]
        == (second["truth.settled.path_error_m.rms"])
    )
    result = CliRunner().invoke(app, ["study", "worst", "r"])
    assert len(result.stdout.splitlines()) == 2
    assert CliRunner().invoke(app, ["study", "report", "r"]).exit_code == 0
    page = Path("r/report.html").read_text(encoding="utf-8")
    assert "2 of 2 flights passed" in page and "<svg" in page and "http-equiv" not in page
    assert load_run_study(Path("r")).name == "tiny"
    more = CliRunner().invoke(app, ["study", "run", "tiny.yaml", "--record", "r", "--resume"])
    assert more.exit_code == 0 and "0 of 2 flights to fly" in more.output


def test_a_requirement_that_fails_is_exit_code_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    strict = TINY.replace("max: 0.5", "max: 0.0001")
    Path("tiny.yaml").write_text(strict, encoding="utf-8")
    figure = {"truth.settled.path_error_m.rms": 0.04}

    def here(cases: list[Case], workers: int, scheduler: str | None, take: Any) -> None:
        for case in cases:
            take({"index": case.index, "passed": False, "outcome": "completed", "unmet": "too far", **figure})

    monkeypatch.setattr("companion.study.engine.flown", here)
    run = CliRunner().invoke(app, ["study", "run", "tiny.yaml", "--record", "r"])
    assert run.exit_code == 1 and "does not hold: 0 of 2" in run.stdout


def test_a_study_that_is_ended_keeps_what_has_landed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By SIGTERM, as a batch system ends a job, as by Ctrl-C."""
    monkeypatch.chdir(tmp_path)
    Path("tiny.yaml").write_text(TINY, encoding="utf-8")

    def here(cases: list[Case], workers: int, scheduler: str | None, take: Any) -> None:
        take({"index": 0, "passed": True, "outcome": "completed"})
        os.kill(os.getpid(), signal.SIGTERM)
        raise AssertionError("it went on")

    monkeypatch.setattr("companion.study.engine.flown", here)
    before = signal.getsignal(signal.SIGTERM)
    run = CliRunner().invoke(app, ["study", "run", "tiny.yaml", "--record", "r"])
    assert run.exit_code == 130 and "1 of 2 flights are still to be flown: --resume" in run.stdout
    assert signal.getsignal(signal.SIGTERM) is before
    assert Path("r/results.csv").read_text().count("\n") == 2
