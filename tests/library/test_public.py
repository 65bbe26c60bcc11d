"""`import companion`: light, typed, and the same as the commands."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import companion
from companion.cli import main
from companion.law.gains import Level
from companion.library.signals import xi_names

HEAVY = ("numpy", "scipy", "pydantic", "yaml", "typer", "pymavlink", "matplotlib", "sim_bridge")


def test_naming_every_public_function_imports_nothing_heavy() -> None:
    program = (
        "import sys, companion\n"
        "for name in companion.__all__: getattr(companion, name)\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_what_is_not_public_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = companion.simulat  # type: ignore[attr-defined]
    assert set(companion.__all__) <= set(dir(companion))


def circle(**keys: object) -> companion.library.files.MissionFile:  # type: ignore[name-defined]
    path = companion.implicit_path("hypot(x, y) - r", "z - height", near=[0, 5, 10], r=5.0, height=10.0)
    return companion.new_mission("circle-r5", path, speed=3.0, frame="enu", **keys)


def test_a_mission_made_in_python_is_the_one_of_its_file() -> None:
    made, read = circle(), companion.load_mission("circle_r5")
    assert made.data == {"yaw": 0.0, **read.data}
    assert made.length == read.length == pytest.approx(10.0 * np.pi, rel=1e-5)
    assert made.value.placement == read.value.placement and made.value.speed == read.value.speed


def test_functions_are_flown_as_the_formulas_they_are() -> None:
    path = companion.implicit_path(lambda x, y, z: np.hypot(x, y) - 5, lambda x, y, z: -z + 10.0, near=[0, 5, 10])
    assert path["h1"] == "(hypot(x, y) - 5.0)" and path["h2"] == "((-z) + 10.0)"
    curve = companion.curve_path(lambda u: (4 * np.cos(u), 3 * np.sin(u), 10 + u**2 / 100), [0, 6])
    mission = companion.new_mission(
        "arc", curve, speed=lambda s: 2 + s / 100, yaw=lambda s: -5 * np.sqrt(s + 1), frame="enu"
    )
    x, y, z = mission.value.table.at(0.0)[0]
    assert (x, y, z) == pytest.approx((0.0, 4.0, -10.0))
    assert mission.value.alpha(10.0) == pytest.approx(2.1)
    assert mission.value.beta(8.0) == pytest.approx(np.radians(-15.0))


def test_a_file_goes_out_and_comes_back_the_same(tmp_path: Path) -> None:
    through = companion.path_through(np.array([[0, 0, -10], [9, 0, -10], [9, 9, -12]]), corner_tolerance=1)
    mission = companion.new_mission("1e3", through, speed=2, vehicle="x500")
    assert companion.load_mission(mission.save(tmp_path / "mine.yaml")).data == mission.data
    heavy = companion.load_vehicle("x500").changed({"mass_kg": 2.4, "rotors[1].thrust_max_n": 9})
    assert (heavy.value.mass, heavy.value.rotors[1].thrust_max, heavy.value.rotors[0].thrust_max) == (2.4, 9.0, 8.54858)
    world = companion.new_world("breeze", wind_mps=[2, 0, 0])
    assert world.value.wind_n == (2.0, 0.0, 0.0) and world.changed({"wind_mps": None}).value.wind_n == (0.0, 0.0, 0.0)


WRONG = [
    (lambda: companion.load_mission("circle_r6"), "circle_r6: no mission of this name; did you mean circle_r5"),
    (lambda: companion.load_vehicle("none.yaml"), "none.yaml: no such file; expected a vehicle file"),
    (lambda: circle(laps=-1), "new_mission('circle-r5'): laps: -1 is too small; expected more than 0"),
    (lambda: companion.load_vehicle("x500").changed({"mass_kg": 9}), "x500.yaml: mass_kg: weighs 88.26 N but"),
    (lambda: companion.load_vehicle("x500").changed({"rotors[7].spin": "cw"}), "rotors[7].spin: leads nowhere"),
    (lambda: companion.new_world("w", wind=3), "new_world('w'): wind: unknown key; did you mean wind_mps?"),
    (lambda: companion.curve_path(lambda u: (u, u), [0, 1]), "curve_path: position: returns 2 values; expected three"),
    (lambda: companion.curve_path(lambda u: (u, abs(u) if u > 0 else 1, 1), [0, 1]), "asks whether something is so"),
    (lambda: companion.implicit_path(lambda x, y: x, "z"), "implicit_path: h1: takes other arguments; expected a function of x"),
    (lambda: companion.simulate("circle_r5", output="rate"), "output: 'rate' is not known; expected auto, motors"),
    (lambda: companion.simulate("circle_r5", gains={"poles": {"pth": [-2]}}), "gains.poles.pth: unknown key; did you mean path?"),
    (lambda: companion.check("circle_r5", companion.load_mission("circle_r5")), "vehicle: a MissionFile; expected a name, a path or a VehicleFile"),
    (lambda: companion.control_law("circle"), "circle.yaml:6: path.kind: circle has no h1 and h2"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "sentence"), WRONG, ids=[sentence[:40] for _, sentence in WRONG])
def test_what_is_wrong_is_said_in_the_sentences_of_the_commands(call, sentence) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(companion.CompanionError) as caught:
        call()
    assert sentence in str(caught.value)


def test_every_fault_at_once() -> None:
    with pytest.raises(companion.CompanionError) as caught:
        companion.simulate("nowhere", "nothing", world="never", output="none", duration=0.0)
    assert len(str(caught.value).splitlines()) == 5


def test_check_says_what_the_command_says(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    report = companion.check("circle_r5", "x500", world="outdoor")
    monkeypatch.setattr(
        "sys.argv", ["companion", "check", "circle_r5", "--vehicle", "x500", "--world", "outdoor", "--json"]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    document = json.loads(capsys.readouterr().out)
    assert ended.value.code == 0 and report.feasible
    assert report.document == {key: value for key, value in document.items() if key != "world"}
    assert report.speed_scale_max == document["speed_scale_max"] and report.headline in str(report)


def test_the_control_law_is_that_of_the_paper() -> None:
    law = companion.control_law("paper_case1")
    chi = [0, 10, -20, 0, 0, 0, -3, 0, 0, 0, 0, 0, 14 * 9.81, 0]
    assert law.state_names[-1] == "zeta_dot" and len(chi) == len(law.state_names)
    answer = law(chi)
    assert answer.xi[:2] == pytest.approx([0.0, 0.0]) and answer.xi[7] == pytest.approx(-18.0 + 18.0, abs=40)
    assert answer.D @ answer.u == pytest.approx(-answer.b + v_of(answer.xi), abs=1e-6)
    with pytest.raises(companion.CompanionError, match="singular: zeta = 0"):
        law([*chi[:12], 0.0, 0.0])
    with pytest.raises(companion.CompanionError, match="13 numbers; expected 14"):
        law(chi[:13])


def v_of(xi: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """-K xi with the poles of the mission: all at -2."""
    gains, at, v = {4: (16, 32, 24, 8), 3: (8, 12, 6), 2: (4, 4)}, 0, []
    for degree in Level.MOTORS.degrees:
        v.append(-sum(k * x for k, x in zip(gains[degree], xi[at : at + degree], strict=True)))
        at += degree
    return np.array(v)


@pytest.fixture(scope="module")
def flight() -> companion.Flight:
    return companion.simulate("circle_r5", duration=3.0, settle=1.0)


def test_a_flight_is_that_of_the_command(
    flight: companion.Flight, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["sim", "circle_r5", "--duration", "3", "--settle", "1", "--record", str(tmp_path / "b"), "--json"]
    monkeypatch.setattr("sys.argv", ["companion", *words])
    with pytest.raises(SystemExit):
        main()
    document = json.loads(capsys.readouterr().out)
    assert flight.completed
    assert {**flight.summary, "record": None} == {**document, "record": None}
    of_command = companion.Flight.load(tmp_path / "b")
    assert of_command.table.tobytes() == flight.table.tobytes()
    same = companion.compare(flight, of_command)
    assert same["truth.settled.path_error_m.rms"].ratio == 1.0
    assert all(row.a == row.b for row in same.rows) and "truth.settled.path_error_m.rms" in str(same)


def test_a_long_flight_is_recorded_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Longer than its record can wait for the disk; with what was said."""
    monkeypatch.setattr("companion.record.table.ROWS_WAITING", 200)
    long = companion.simulate("circle_r5", duration=3.0, settle=1.0, record=tmp_path / "long")
    assert len(long.table) > 400 and long.summary["follow"]["duration_s"] == pytest.approx(3.0, abs=0.1)
    assert "-> follow" in (tmp_path / "long" / "notes.txt").read_text()


def test_a_flight_as_arrays_with_units(flight: companion.Flight, tmp_path: Path) -> None:
    assert flight.units["path_error"] == "m" and flight.units["v_north"] == "m/s" and flight.units["mode"] == ""
    assert "distance to the path" in flight.meanings["path_error"]
    rows = np.genfromtxt(flight.to_csv(tmp_path / "flight.csv"), delimiter=",", names=True)
    assert rows["t_boot"] == pytest.approx(np.asarray(flight.table["t_boot"]), nan_ok=True)
    assert flight.xi.names == xi_names(Level.RATES) and flight.xi.values.shape == (len(flight.xi.t), 9)
    across = np.hypot(flight.xi["h1"], flight.xi["h2"])
    assert across == pytest.approx(flight.followed["path_error"], abs=1e-6)
    assert flight.followed_truth is not None
    assert flight.followed_truth["path_error"].max() == flight.summary["truth"]["follow"]["path_error_m"]["max"]
    assert flight.u.names == ("zeta_dot", "p", "q", "r") and np.all(np.isfinite(flight.u["p"]))
    assert "completed, path error" in repr(flight)
    pytest.importorskip("pandas")
    assert list(flight.to_pandas()["path_error"]) == pytest.approx(list(flight.table["path_error"]), nan_ok=True)


def test_a_flight_that_nobody_keeps_goes_and_one_that_is_saved_stays(flight: companion.Flight, tmp_path: Path) -> None:
    kept = flight.save(tmp_path / "kept")
    assert kept.summary == flight.summary and (tmp_path / "kept" / "mission.yaml").is_file()
    with pytest.raises(companion.CompanionError, match="is not empty"):
        flight.save(tmp_path / "kept")
    with pytest.raises(companion.CompanionError, match=r"resolved.json is missing; expected a flight folder"):
        companion.Flight.load(tmp_path)
