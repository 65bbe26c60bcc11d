"""The direction of imports: a room stands only on the rooms its row names. Change the table when you mean to."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

MAY_IMPORT: dict[str, str] = {
    "frames": "",
    "plain_text": "",
    "version": "",
    "geodesy": "frames",
    "calculus": "",
    "mavlink_common": "",
    "plans": "frames fence geodesy mavlink_common",
    "fence": "frames",
    "vehicle": "frames",
    "world": "frames",
    "paths": "frames calculus vehicle",
    "profiles": "frames calculus paths",
    "law": "frames calculus vehicle paths profiles",
    "mission": "frames geodesy fence calculus vehicle paths profiles law",
    "places": "frames fence geodesy mavlink_common plans vehicle paths profiles mission",
    "allocation": "vehicle",
    "px4_allocation": "frames vehicle allocation",
    "thrust_range": "vehicle",
    "estimation": "frames calculus vehicle",
    "steering": "frames calculus vehicle paths law allocation px4_allocation thrust_range estimation",
    "feasibility": "frames fence calculus vehicle paths profiles law allocation thrust_range mission",
    "identification": "plain_text mavlink_common frames vehicle px4_allocation",
    "flight": "mavlink_common vehicle fence",
    "plan": "frames vehicle paths profiles law mission estimation steering flight",
    "settings": "law plan",
    "pilot": "frames vehicle law paths mission steering flight plan",
    "mavlink": "frames vehicle plain_text mavlink_common",
    "xrce": "vehicle",
    # mavlink: world files name messages
    "config": "plain_text mavlink_common frames fence geodesy plans calculus vehicle world paths profiles law mission "
    "mavlink",
    "record": "version mavlink_common frames geodesy vehicle world paths law mission estimation steering feasibility plan settings flight pilot mavlink "
    "xrce config",
    "daemon": "plain_text mavlink_common frames geodesy vehicle paths estimation flight mission places plan settings pilot mavlink "
    "xrce "
    "record",
    "services": "frames fence geodesy mavlink_common vehicle flight places plans",
    "library": "frames geodesy calculus vehicle world paths law mission places allocation px4_allocation feasibility flight plan pilot "
    "mavlink config record daemon",
    "watch": "plain_text record daemon",
    "study": "version vehicle calculus config record library",
    "cli": "*",
}
# calculus: arithmetic, which knows nothing that flies
SIM_BRIDGE = {"calculus", "plain_text", "mavlink_common", "frames", "geodesy", "vehicle", "world", "mavlink", "xrce"}
SIM_BRIDGE_SHELL = {"sim_bridge/__main__.py", "sim_bridge/server.py"}
IMPURE = {"socket", "select", "time", "signal", "threading", "random", "subprocess", "os", "termios", "gc"}
MAY_BE_IMPURE = {"daemon", "config", "record", "services", "watch", "library", "study", "cli"}


def imports(path: Path) -> set[str]:
    """The modules a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            found.add(node.module)
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def room_of(module: str) -> str | None:
    parts = module.split(".")
    return parts[1] if parts[0] == "companion" and len(parts) > 1 and parts[1] in MAY_IMPORT else None


COMPANION_FILES = sorted((ROOT / "companion").rglob("*.py"))
SIM_FILES = sorted((ROOT / "sim_bridge").rglob("*.py"))


def room(path: Path) -> str:
    first = path.relative_to(ROOT / "companion").parts[0]
    return first.removesuffix(".py")


@pytest.mark.parametrize("path", COMPANION_FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_room_stands_only_on_the_rooms_of_its_row(path: Path) -> None:
    here = room(path)
    if here in ("__init__", "__main__"):
        return
    allowed = set(MAY_IMPORT) if MAY_IMPORT[here] == "*" else {here, *MAY_IMPORT[here].split()}
    used = {room_of(module) for module in imports(path)} - {None}
    assert used <= allowed, f"{here} may not import {sorted(map(str, used - allowed))}"
    if here not in ("library", "cli"):
        assert not any(module.split(".")[0] == "sim_bridge" for module in imports(path))


@pytest.mark.parametrize("path", SIM_FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_the_plant_shares_no_model_with_the_controller(path: Path) -> None:
    allowed = SIM_BRIDGE | ({"config"} if str(path.relative_to(ROOT)) in SIM_BRIDGE_SHELL else set())
    used = {room_of(module) for module in imports(path)} - {None}
    assert used <= allowed, f"the plant may not import {sorted(map(str, used - allowed))}"


@pytest.mark.parametrize("path", COMPANION_FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_sockets_clocks_files_and_chance_stay_behind_their_doors(path: Path) -> None:
    if room(path) in MAY_BE_IMPURE | {"__main__"}:
        return
    used = {module.split(".")[0] for module in imports(path)} & IMPURE
    assert not used, f"{room(path)} may not touch {sorted(used)}"


def test_the_table_names_every_room() -> None:
    rooms = {room(path) for path in COMPANION_FILES} - {"__init__", "__main__"}
    assert rooms == set(MAY_IMPORT)


def test_no_room_is_ever_told_to_stand_on_itself_in_a_circle() -> None:
    stands_on = {name: set(row.split()) - {"*"} for name, row in MAY_IMPORT.items()}
    placed: set[str] = set()
    while len(placed) < len(stands_on):
        ready = {name for name, below in stands_on.items() if name not in placed and below <= placed}
        assert ready, f"a circle among {sorted(set(stands_on) - placed)}"
        placed |= ready


def test_nothing_sleeps_in_the_flight() -> None:
    for path in COMPANION_FILES:
        if room(path) == "services":  # off the control path
            continue
        assert "time.sleep" not in path.read_text(encoding="utf-8"), path


@pytest.mark.parametrize("path", sorted((ROOT / "bench").rglob("*.py")), ids=lambda path: path.name)
def test_a_benchmark_finds_what_it_imports(path: Path) -> None:
    """Nobody runs them all at every change."""
    importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))


@pytest.mark.parametrize(("here", "away"), [("bench", {"tests"}), ("tests", {"bench"}), ("trials", {"bench", "tests"})])
def test_benchmarks_and_tests_meet_only_in_trials(here: str, away: set[str]) -> None:
    for path in sorted((ROOT / here).rglob("*.py")):
        used = {module.split(".")[0] for module in imports(path)} & away
        assert not used, f"{path} may not import from {sorted(used)}: what both need stands in trials/"


FUNCTION_MAX, FILE_MAX = 60, 300
"""Lines. No exceptions in the two packages."""
CONTROL = (
    "estimation", "steering", "law", "flight", "pilot", "allocation.py", "px4_allocation.py", "thrust_range.py", "plan.py"
)  # fmt: skip
CONTROL_FILES = [path for path in COMPANION_FILES if path.relative_to(ROOT / "companion").parts[0] in CONTROL]


@pytest.mark.parametrize("path", [*COMPANION_FILES, *SIM_FILES], ids=lambda p: str(p.relative_to(ROOT)))
def test_a_function_is_read_on_one_screen_and_a_file_in_one_go(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= FILE_MAX, f"{path.name} has {text.count(chr(10))} lines"
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            length = (node.end_lineno or node.lineno) - node.lineno + 1
            assert length <= FUNCTION_MAX, f"{node.name} has {length} lines"


UNITS = re.compile(
    r"(\(?(s|us|ms|m|m/s|rad|rad/s|Hz|N|kg|V|A|mV|days|degrees|bytes|deg)(\^\d|/s\^\d|/s|/rad| m|\)\^\d)*"
    r"|1/s(\^\w)?|Ratios?|Shares?|Factors?|Cosine|Normalised|Number|Index|Bits?|Codes?)(?![\w/^])"
)
"""How the text of a constant begins: its unit, or what kind of number without a unit it is."""
SOURCES = re.compile(
    r"[Ee]ngineering choice|PX4|paper|Eq\.|Lemma|MAVLink|[Ii]ssue \d|bench\.\w|[Ss]weep|[Rr]ecorded|[Ss]imulated|[Ff]lown"
    r"|[Ff]lights on|[Mm]easured|[Bb]y definition|As [A-Z_]{3,}"
)
"""Where it comes from: one of these stands in its text."""


def figures(path: Path) -> Iterator[tuple[int, ast.expr, str]]:
    """(line, target, text) of every constant of a module with a number in it. Enumerations are none: their names say it.

    A value that only names another constant needs no unit and source of its own.
    """
    body = ast.parse(path.read_text(encoding="utf-8")).body
    lines = path.read_text(encoding="utf-8").split("\n")
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign) or node.value is None:
            continue
        numbers = [x.value for x in ast.walk(node.value) if isinstance(x, ast.Constant)]
        hidden = any(isinstance(x, ast.Call) and ast.unparse(x.func) in ("float", "int") for x in ast.walk(node.value))
        if not hidden and not any(isinstance(x, int | float) and not isinstance(x, bool) for x in numbers):
            continue
        text = ""
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str):
            text = after.value.value
        else:
            beside = lines[(node.end_lineno or node.lineno) - 1].partition("#")[2].replace("fmt: skip", "")
            above = lines[node.lineno - 2].strip()
            text = beside.strip() or (above[1:].strip() if above.startswith("#") else "")
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            yield node.lineno, target, " ".join(text.split())


@pytest.mark.parametrize("path", [*CONTROL_FILES, *SIM_FILES], ids=lambda p: str(p.relative_to(ROOT)))
def test_constants_stand_one_a_line_and_say_what_they_are(path: Path) -> None:
    for line, target, text in figures(path):
        assert isinstance(target, ast.Name), f"line {line}: one constant a line"
        assert text, f"line {line}: {target.id} says neither unit nor meaning"


@pytest.mark.parametrize("path", CONTROL_FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_figure_of_the_control_says_its_unit_and_its_source(path: Path) -> None:
    for line, target, text in figures(path):
        name = ast.unparse(target)
        assert UNITS.match(text), f"line {line}: {name} does not begin with its unit: {text}"
        assert SOURCES.search(text), f"line {line}: {name} does not say where it comes from: {text}"


def test_a_figure_without_unit_or_source_is_found(tmp_path: Path) -> None:
    """However it is written."""
    for source in ("A = 0.3", "A = 3", "A: float = -1e-3", "A = float('0.3')", "A = (1.0, B)", "A = 2 * B", "A = f(7)"):
        file = tmp_path / "figure.py"
        file.write_text(f"{source}\nC = 'text'\n", encoding="utf-8")
        ((line, target, text),) = figures(file)
        assert (line, ast.unparse(target), text) == (1, "A", ""), source
    assert (
        UNITS.match("m/s^2, of W")
        and UNITS.match("(rad/s)^2: of")
        and UNITS.match("1/s^3, of c")
        and UNITS.match("N m")
    )
    assert not any(UNITS.match(text) for text in ("so many", "seconds until", "The share", "metres", "1/s/x"))
    assert not SOURCES.search("s until it is told")


@pytest.mark.parametrize("path", CONTROL_FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_public_type_of_the_control_is_in_the_glossary(path: Path) -> None:
    glossary = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            assert f"`{node.name}`" in glossary, f"{node.name} is not in docs/glossary.md"


@pytest.mark.parametrize("package", ["companion", "sim_bridge"])
def test_the_face_of_a_room_names_all_that_is_in_it(package: str) -> None:
    """So that whoever looks for something, or for a place for it, reads one list."""
    for face in sorted((ROOT / package).rglob("__init__.py")):
        text = ast.get_docstring(ast.parse(face.read_text(encoding="utf-8"))) or ""
        inside = {path.stem for path in face.parent.glob("*.py")} | {
            path.parent.name for path in face.parent.glob("*/__init__.py")
        }
        unnamed = {
            name
            for name in inside - {"__init__", "__main__"}
            if not re.search(rf"\b{name}\b|\b{name.rsplit('_', 1)[0]}_", text)
        }
        assert not unnamed, f"{face.relative_to(ROOT)} does not name {sorted(unnamed)}"


@pytest.mark.parametrize("package", ["companion", "sim_bridge"])
def test_no_modules_import_each_other_in_a_circle(package: str) -> None:
    """Not even where only types are imported."""
    files = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in (ROOT / package).rglob("*.py")
    }
    stands_on = {name: {each for each in imports(path) if each in files} - {name} for name, path in files.items()}
    for name, below in stands_on.items():  # a package's own list of what it gives is no circle
        below -= {each for each in below if name.startswith(f"{each}.")}
    placed: set[str] = set()
    while len(placed) < len(stands_on):
        ready = {name for name, below in stands_on.items() if name not in placed and below <= placed}
        assert ready, f"a circle among {sorted(set(stands_on) - placed)}"
        placed |= ready
