"""What a newcomer reads first: the help with its defaults, completion, near names, and how much is said."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.cli.options import complete_mission, complete_vehicle, complete_world
from companion.cli.terminal import busy

COMMANDS = (
    "check",
    "sim",
    "fly",
    "demo",
    "preflight",
    "law",
    "report",
    "replay",
    "status",
    "export",
    "new",
    "schema",
    "export-flight",
    "watch",
)


def help_of(*words: str) -> str:
    result = CliRunner(env={"COLUMNS": "200", "TERM": "dumb"}).invoke(app, [*words, "--help"])
    assert result.exit_code == 0
    return re.sub(r"[│\s]+", " ", re.sub(r"\x1b\[[0-9;]*m", "", result.stdout))


@pytest.mark.parametrize("command", COMMANDS)
def test_every_default_is_in_the_help(command: str) -> None:
    text = help_of(command)
    for parameter in typer.main.get_command(app).commands[command].params:  # type: ignore[attr-defined]
        if parameter.param_type_name == "option" and parameter.default not in (None, False, ()):
            assert any(name in text for name in parameter.opts)
            assert "[default: " in text
    assert "s of following" not in text and "Of every chance" not in text


def test_defaults_that_depend_are_told_in_words() -> None:
    text = help_of("sim")
    for words in (
        "[default: (the mission's own, else x500)]",
        "[default: ideal]",
        "[default: 0]",
        "flights/DATE-TIME-NAME",
    ):
        assert words in text, text
    assert "pilot on a serial line, else companion" in help_of("fly")
    assert "--install-completion" in help_of()


def test_names_are_completed() -> None:
    assert complete_mission("circle_r1") == ["circle_r10"]
    assert complete_vehicle("x") == ["x500"]
    assert "outdoor" in complete_world("")


def test_a_name_that_is_nearly_right_is_offered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_mission.yaml").write_text("mission: mine\n")
    for wrong, right in (("cirle", "circle"), ("my_mision.yaml", "my_mission.yaml"), ("my_mission", "my_mission.yaml")):
        result = CliRunner().invoke(app, ["check", wrong])
        assert f"did you mean {right}" in str(result.exception), result.exception
    assert "did you mean outdoor" in str(CliRunner().invoke(app, ["sim", "circle", "--world", "outdor"]).exception)


def test_quiet_leaves_the_result_and_verbose_says_more(tmp_path: Path) -> None:
    words = ["sim", "circle_r5", "--duration", "2", "--settle", "1", "--record"]
    quiet, normal, verbose = (
        CliRunner().invoke(app, [*words, str(tmp_path / name), *more])
        for name, more in (("quiet", ["-q"]), ("normal", []), ("verbose", ["-v"]))
    )
    assert quiet.exit_code == normal.exit_code == verbose.exit_code == 0
    assert quiet.stderr == "" and "completed" in quiet.stdout
    assert "join -> follow" in normal.stderr
    assert "circle_r5.yaml" in verbose.stderr and verbose.stderr.count("path error") > normal.stderr.count("path error")


def test_what_takes_long_is_named(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.cli.terminal.BUSY_AFTER", 0.0)
    said: list[str] = []
    monkeypatch.setattr("companion.cli.terminal.say", said.append)
    with busy("checking"):
        while not said:  # the other thread says so at once
            pass
    assert said[0].startswith("checking ... 0 s")
    with busy("nothing"):
        pass
