"""``companion law`` as its users call it: files in, states as JSON lines in, JSON lines out."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from companion.cli.bare import answers
from companion.law.gains import Level
from companion.library.orders import read_bare
from tests.law.test_exact_derivatives import GIVEN, cases, error

ROTORS = (([0.1, 0, 0], "ccw"), ([0, 0.1, 0], "cw"), ([-0.1, 0, 0], "ccw"), ([0, -0.1, 0], "cw"))
PAPER_STATE = [0, 10, -20, 0, 0, 0, 1, 0, 0, 0, 0, 0, 19, 0]


def files(case: dict[str, Any], directory: Path) -> tuple[str, str]:
    """The mission and the vehicle of a case, as somebody would write them down."""
    h1, h2, alpha, beta = GIVEN[case["path"]]
    gains, model = case["gains"], case["model"]
    mission, vehicle = directory / "m.yaml", directory / "v.yaml"
    mission.write_text(
        f"mission: case\nframe: ned\npath:\n  kind: implicit\n  h1: {h1}\n  h2: {h2}\n"
        f"  constants: {json.dumps(case['path_params'])}\n"
        f"speed: {alpha}\nyaw: degrees({beta})\n"
        f"gains: {{h1: {gains['k1']}, h2: {gains['k2']}, h3: {gains['k3']}, h4: {gains['k4']}}}\n"
    )
    rotors = "".join(
        f"  - {{position_m: {p}, spin: {s}, thrust_max_n: 250, torque_per_thrust_m: 0.0125, command: [-1, 1]}}\n"
        for p, s in ROTORS
    )
    vehicle.write_text(
        f"name: case\nmass_kg: {model['m']}\ngravity: {model['g']}\n"
        f"inertia_kgm2: [{model['Ix']}, {model['Iy']}, {model['Iz']}]\nrotors:\n{rotors}limits: none\n"
    )
    return str(mission), str(vehicle)


def answered(mission: str, vehicle: str | None, level: Level, lines: Iterable[str]) -> list[dict[str, Any]]:
    out = io.StringIO()
    answers(*read_bare(mission, vehicle, level), level, lines, out)
    return [json.loads(line) for line in out.getvalue().splitlines()]


@pytest.mark.parametrize(
    ("level", "case"),
    [(Level.MOTORS, case) for case in cases("law_cases.json")]
    + [(Level.RATES, case) for case in cases("law_cases_level3.json")],
    ids=lambda x: x.name if isinstance(x, Level) else f"{x['path']}-{x['id']}",
)
def test_every_given_case_through_files(level: Level, case: dict[str, Any], tmp_path: Path) -> None:
    (answer,) = answered(*files(case, tmp_path), level, [json.dumps({"chi": case["chi"]})])
    inputs = "ubar" if level is Level.MOTORS else "u"
    assert set(answer) == {"xi", "b", "D", inputs, "eta"} | ({"tau"} if level is Level.MOTORS else set())
    for key in ("xi", "b", "D", inputs):
        assert error(answer[key], case[key]) < 1e-9
    if level is Level.MOTORS:
        d, c = 0.1, 80.0
        M = np.array([[c] * 4, [0, -c * d, 0, c * d], [c * d, 0, -c * d, 0], [1, -1, 1, -1]])
        u = (case["chi"][12], *case["ubar"][1:])
        assert M @ answer["tau"] == pytest.approx(u, abs=1e-9 * max(map(abs, u)))  # tau = M^-1 u, the paper's plus


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (json.dumps({"chi": [*PAPER_STATE[:12], 0, 0]}), "singular: zeta = 0"),
        (json.dumps({"chi": [0, 10, -20, 0, np.pi / 2, *PAPER_STATE[5:]]}), "singular: theta = +-90 deg"),
        (json.dumps({"chi": [0, 10, -20, 0, 0, -np.pi / 2, *PAPER_STATE[6:]]}), "singular: phi = +-90 deg"),
        (json.dumps({"chi": [0, 0, *PAPER_STATE[2:]]}), "singular: grad h1 and grad h2"),
        (json.dumps({"chi": [float("nan"), *PAPER_STATE[1:]]}), "a number that is not finite"),
        (f'{{"chi": [{"9" * 400}, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13]}}', "a number that is not finite"),
        (json.dumps({"chi": PAPER_STATE[:10]}), "10 numbers; expected 14"),
        (json.dumps({"chi": [*PAPER_STATE[:13], True]}), "not a state"),
        (json.dumps({"chi": ["0", *PAPER_STATE[1:]]}), "not a state"),
        (json.dumps({"chi": 3}), "not a state"),
        (json.dumps([1, 2]), "not a state"),
        ("[" * 100_000, "not a state"),
        ("{", "not a state"),
    ],
)
def test_a_line_without_an_answer_says_why_and_the_run_goes_on(line: str, said: str) -> None:
    good = json.dumps({"chi": PAPER_STATE})
    before, answer, after = answered("paper_case1", None, Level.MOTORS, [good, "", line, good])
    assert before == after
    assert "xi" in before
    assert list(answer) == ["error"]
    assert answer["error"].startswith(said)


def test_a_path_that_closes_nowhere_has_its_law_all_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mission = tmp_path / "wave.yaml"
    mission.write_text(
        "mission: wave\nframe: enu\npath: {kind: implicit, h1: y - 2*sin(x/3), h2: z - 5 - exp(-x**2/50)}\n"
        "speed: 2 + atan(x)/4\nyaw: 10*tan(y/20)\n"
    )
    (answer,) = answered(str(mission), "sih", Level.RATES, [json.dumps({"chi": [0, 0.1, -5, 0, 0, 0, 1, 0, 0, 10]})])
    assert answer["eta"] is None
    assert len(answer["xi"]) == 9
    assert "eta is null: the path does not close" in capsys.readouterr().err


def test_what_has_no_answer_is_told_with_its_line_and_an_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    good, singular = list(PAPER_STATE), list(PAPER_STATE)
    singular[12] = 0.0  # no thrust
    mission, vehicle = read_bare("paper_case1", None, Level.MOTORS)

    def run(*lines: str) -> tuple[int, str]:
        output = answers(mission, vehicle, Level.MOTORS, lines, io.StringIO())
        return output.exit_code, capsys.readouterr().err

    whole = json.dumps({"chi": good})
    assert run(whole, whole) == (0, "")
    code, said = run(whole, json.dumps({"chi": singular}), whole)
    assert code == 1 and said.startswith("line 2: singular")
    code, said = run("nonsense", json.dumps({"chi": singular}))
    assert code == 2 and "line 1: not a state" in said and "line 2: singular" in said
