"""The main figures, through ``companion sim`` over MAVLink in lockstep."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest


def companion(*arguments: str, cwd: Path, stdin: str = "", time_out: float = 200.0) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "companion", *arguments],
        cwd=cwd, input=stdin, capture_output=True, text=True, timeout=time_out, check=False,
    )  # fmt: skip


def sim(*arguments: str, cwd: Path) -> dict[str, Any]:
    done = companion("sim", *arguments, "--json", cwd=cwd)
    assert done.returncode == 0, done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


@pytest.mark.parametrize(
    ("case", "angle", "thrust", "speed"),
    [("paper_case1", 5.2418, 19.7024, 3.0), ("paper_case2", 66.4428, 49.0912, 15.0)],
)
def test_the_papers_cases(case: str, angle: float, thrust: float, speed: float, tmp_path: Path) -> None:
    done = companion("sim", case, "--duration", "25", "--settle", "12", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    settled = figures["settled"]
    tolerance = 0.05 if case == "paper_case1" else 0.1
    assert settled["roll_max_deg"] == pytest.approx(angle, abs=tolerance)
    assert settled["pitch_max_deg"] == pytest.approx(angle, abs=tolerance)
    assert settled["thrust_n"]["min"] == pytest.approx(thrust, abs=0.05)
    assert settled["thrust_n"]["max"] == pytest.approx(thrust, abs=0.05)
    assert settled["path_error_m"]["max"] < 0.01
    assert settled["speed_error_mps"]["max"] < 0.01
    assert figures["truth"]["settled"]["path_error_m"]["max"] < 0.01
    assert figures["loop"]["rate_hz"] == pytest.approx(1000.0, rel=1e-3)
    (note,) = figures["notes"]
    assert note.startswith("the motors go negative: least -")
    assert figures["settled"]["laps"] == pytest.approx(13.0 * speed / (20.0 * math.pi), rel=1e-3)


def test_circle_on_an_x500_with_motor_lag_and_drag(tmp_path: Path) -> None:
    figures = sim("circle_r5", "--output", "motors", "--duration", "25", "--record", "flight", cwd=tmp_path)
    for settled in (figures["settled"], figures["truth"]["settled"]):
        assert settled["path_error_m"]["rms"] < 0.005
        assert settled["speed_error_mps"]["rms"] < 0.05
        assert settled["yaw_error_deg"]["rms"] < 1.0
        assert settled["motor"]["saturated_fraction"] == 0.0
    assert figures["schema"] == "companion.flight/1"
    assert figures["outcome"] == "completed"
    assert figures["loop"]["latency_us"] is None
    assert [phase["phase"] for phase in figures["phases"]] == [
        "preflight",
        "take over",
        "settle",
        "follow",
        "hand back",
        "done",  # until the rate of states is known
    ]
    folder = tmp_path / "flight"
    assert {p.name for p in folder.iterdir()} == {
        "flight.npy", "link.tlog", "mission.yaml", "notes.txt", "resolved.json", "summary.json", "truth.npy",
        "vehicle.yaml", "world.yaml",
    }  # fmt: skip
    assert json.loads((folder / "summary.json").read_text()) == figures
    done = companion("replay", "flight", cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    assert "bit for bit" in done.stdout


@pytest.mark.xdist_group("real time")
def test_two_processes_over_udp_in_real_time(tmp_path: Path) -> None:
    figures = sim(
        "circle_r5",
        "--output",
        "motors",
        "--duration",
        "9",
        "--settle",
        "5",
        "--udp",
        "--record",
        "flight",
        cwd=tmp_path,
    )
    assert figures["settled"]["path_error_m"]["rms"] < 0.02
    assert figures["settled"]["speed_error_mps"]["rms"] < 0.05
    assert figures["settled"]["yaw_error_deg"]["rms"] < 1.0
    assert figures["truth"]["settled"]["path_error_m"]["rms"] < 0.02
    assert figures["loop"]["latency_us"]["p50"] > 0.0
    assert companion("replay", "flight", cwd=tmp_path).returncode == 0


def test_a_changed_record_is_found(tmp_path: Path) -> None:
    import numpy as np

    sim("circle_r5", "--output", "motors", "--duration", "2", "--record", "flight", cwd=tmp_path)
    file = tmp_path / "flight" / "flight.npy"
    table = np.load(file)
    table["north"][300:302] += 1e-9  # two states: at 250 Hz the filter takes every second one
    np.save(file, table)
    done = companion("replay", "flight", cwd=tmp_path)
    assert done.returncode == 1
    # the filter takes a state in when its setpoint is on its way, so that the next one is the first that differs
    assert re.search(r"differs at tick 30[12]", done.stdout)


def test_the_law_command_answers_the_given_cases(tmp_path: Path) -> None:
    """Mission and vehicle files made from a case, states in, the paper's matrices out."""
    data = json.loads((Path(__file__).parents[1] / "data" / "law_cases.json").read_text())
    cases = [case for case in data["cases"] if case["path"] == "ellipse_profile"]
    params, model, gains = cases[0]["path_params"], cases[0]["model"], cases[0]["gains"]
    (tmp_path / "m.yaml").write_text(
        f"""
mission: case
frame: ned
path:
  kind: implicit
  constants: {json.dumps({k: v for k, v in params.items() if k not in ("beta", "beta1", "beta2")})}
  h1: (x/a)**2 + (y/b)**2 - 1
  h2: z - z0 - kx*x - ky*y
speed: alpha + alpha1*(y/b)/hypot(x/a, y/b)
yaw: degrees({params["beta"]} + {params["beta1"]}*(x/a)/hypot(x/a, y/b) + {params["beta2"]}*y/b)
gains: {{h1: {gains["k1"]}, h2: {gains["k2"]}, h3: {gains["k3"]}, h4: {gains["k4"]}}}
"""
    )
    rotors = "".join(
        f"  - {{position_m: {p}, spin: {s}, thrust_max_n: 9, torque_per_thrust_m: 0.02}}\n"
        for p, s in (([0.2, 0, 0], "ccw"), ([0, 0.2, 0], "cw"), ([-0.2, 0, 0], "ccw"), ([0, -0.2, 0], "cw"))
    )
    (tmp_path / "v.yaml").write_text(
        f"name: case\nmass_kg: {model['m']}\ngravity: {model['g']}\n"
        f"inertia_kgm2: [{model['Ix']}, {model['Iy']}, {model['Iz']}]\nrotors:\n{rotors}"
    )
    lines = [json.dumps({"chi": case["chi"]}) for case in cases]
    bad = [json.dumps({"chi": [0.0] * 14}), "{", json.dumps({"chi": [1, 2]})]
    done = companion("law", "m.yaml", "--vehicle", "v.yaml", cwd=tmp_path, stdin="\n".join([*lines, *bad]))
    assert done.returncode == 2  # two lines are no states; the others were answered all the same
    assert [line.split(":")[0] for line in done.stderr.splitlines()] == [f"line {len(lines) + n}" for n in (1, 2, 3)]
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    for case, answer in zip(cases, answers, strict=False):
        for key in ("xi", "b", "ubar"):
            scale = max(map(abs, case[key]))
            assert answer[key] == pytest.approx(case[key], abs=1e-9 * scale)
        assert len(answer["tau"]) == 4
        assert 0.0 <= answer["eta"] < 50.0
    assert [sorted(answer) for answer in answers[len(cases) :]] == [["error"]] * 3
    assert answers[len(cases)]["error"] == "singular: zeta = 0"


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (("sim", "nowhere"), 2, "no mission of this name"),
        (("sim", "nowhere", "--vehicle", "nothing", "--world", "nought"), 2, "nought: no world"),
        (("sim",), 2, "Missing argument"),
        (("sim", "circle_r5", "--output", "sideways"), 2, "sideways"),
        (("fly", "circle_r5", "--connect", "udp:127.0.0.1"), 2, "--connect: "),
        (("fly", "circle_r5", "--connect", "serial:///dev/no-such-device:921600"), 2, "cannot be opened"),
        (("replay", "."), 2, "expected a flight folder"),
        (
            ("fly", "circle_r5", "--connect", "udpin://127.0.0.1:24540"),
            3,
            "no vehicle: listened to UDP 127.0.0.1:24540",
        ),
    ],
)
def test_exit_codes(arguments: tuple[str, ...], code: int, said: str, tmp_path: Path) -> None:
    done = companion(*arguments, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []  # nothing was started
