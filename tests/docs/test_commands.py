"""Every command that README and docs show: those that need no vehicle are run, the others are parsed.

A page's commands run in their order in one folder, so that a file which an earlier one writes is there for a later one.
Flights are made short; nothing else of a command is changed. Commands of other programs (apt, docker, systemctl) are
only looked at: they must be among those that are known here.
"""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.vehicle import CompanionError
from sim_bridge.__main__ import fly as fly_bridge

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
RUN = {"check", "sim", "demo", "export", "export-flight", "law", "new", "replay", "report", "schema", "status"}
PARSED = {"fly", "preflight", "study", "vehicle", "watch"}
OTHERS = {"docker", "sudo", "echo", "kill", ".", "openssl", "umask", "(umask", "git", "cd"}
SHORT = ("--duration", "1", "--settle", "0.5", "--no-report")
GIVEN = {"my_mission.yaml": "circle", "my_circle.yaml": "circle", "my_quad.yaml": "vehicle"}
"""Files that a reader has by the time: examples of these kinds, where a page does not write them itself."""
EXPECTED = {"status": {0, 1}}
"""Exit codes that are as they should be, beside 0."""

bridge_app = typer.Typer()
bridge_app.command()(fly_bridge)


def commands_of(page: Path) -> list[str]:
    """Every command of the shell blocks of a page, comments cut off and continued lines joined."""
    found = []
    for block in re.findall(r"```(?:sh|bash)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        for line in re.sub(r"\\\n\s*", " ", block).splitlines():
            bare = re.sub(r"\s+#.*", "", line).strip()
            if bare and not bare.startswith("#"):
                found.append(bare)
    return found


def make_targets() -> set[str]:
    return set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))


def shortened(words: list[str]) -> list[str]:
    """A flight of a second, in this process."""
    if words[0] == "demo":
        return [*words, "--fast"]
    kept = [word for word in words if word not in ("--udp", "--no-report", "--report")]
    for option in ("--duration", "--settle"):
        if option in kept:
            at = kept.index(option)
            del kept[at : at + 2]
    return [*kept, *SHORT]


def parse(words: list[str], command: object) -> None:
    """The command line is one that the program takes: every command, option and number of arguments."""
    context = None
    while hasattr(command, "commands"):
        name, words = words[0], words[1:]
        command = command.commands[name]
    context = command.make_context("docs", list(words), resilient_parsing=False)  # type: ignore[attr-defined]
    assert context is not None


def run(line: str) -> None:
    """One command line of companion: what is before a pipe is its stdin, what is after > is a file."""
    stdin = None
    if "|" in line:
        before, line = (part.strip() for part in line.split("|"))
        stdin = " ".join(shlex.split(before)[1:])
    line, _, target = line.partition(">")
    words = shlex.split(line.rstrip("& "))[1:]
    if words[0].startswith("--"):  # an option of the program itself, such as --install-completion
        assert words[0] in CliRunner(env={"COLUMNS": "200"}).invoke(app, ["--help"]).stdout
        return
    if words[0] in PARSED or "--ulog-join" in words:  # no log of a vehicle is at hand here
        parse(words, typer.main.get_command(app))
        return
    assert words[0] in RUN, f"{words[0]}: a new command, is it run or parsed?"
    result = CliRunner().invoke(app, shortened(words) if words[0] in ("sim", "demo") else words, input=stdin)
    if isinstance(result.exception, CompanionError):
        raise AssertionError(f"{line}: {result.exception}") from result.exception
    assert result.exit_code in EXPECTED.get(words[0], {0}), f"{line}: {result.output}"
    if target.strip():
        Path(target.strip()).write_text(result.stdout, encoding="utf-8")


def look_at(line: str) -> None:
    """One command line, whichever program it is for."""
    words = shlex.split(line, comments=True)
    match words:
        case ["make", *rest]:
            assert all(word in make_targets() or "=" in word for word in rest)
        case ["companion", *_]:
            run(line)
        case ["echo", *_] if "companion" in words:
            run(line)
        case ["sim-bridge", *rest]:
            parse([word for word in rest if word != "&"], typer.main.get_command(bridge_app))
        case ["python", "-m", module, *_]:
            assert importlib.util.find_spec(module) is not None
        case [program, *_]:
            assert program in OTHERS, f"{program} is not known here"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    lines = commands_of(page)
    (tmp_path / "field.plan").write_bytes((ROOT / "configs/missions/survey.plan").read_bytes())
    for name, kind in GIVEN.items():
        if not any(re.match(rf"companion new \w+ {name}", line) for line in lines):
            assert CliRunner().invoke(app, ["new", kind, name]).exit_code == 0
    for line in lines:
        look_at(line)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_between_pages_leads_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)#:]+?)(?:#[^)]*)?\)", text):
        assert (page.parent / link).exists(), link
    for link in re.findall(r"`(docs/[\w./-]+|configs/[\w./-]+|bench/[\w./-]+\.py)`", text):
        assert (ROOT / link).exists(), link


def test_the_index_names_every_page() -> None:
    index = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert page.name == "README.md" or f"({page.name})" in index, page.name
