"""Mission files and plans spoilt as people and programs spoil them, the same for the same seed."""

from __future__ import annotations

import random
import re
import traceback
from collections.abc import Callable
from pathlib import Path

from companion.cli.check import check_sortie
from companion.cli.output import Output
from companion.config.examples import PATHS, example, example_plan
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.file_lookup import SHIPPED, names
from companion.library.orders import read_sortie

Mutation = Callable[[random.Random, str], str]

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
KEY = re.compile(r"^(\s*(?:- )?)([a-z_0-9]+)(:)", re.MULTILINE)
NUMBERS = (
    "1e308",
    "-1e308",
    "1e-300",
    "0",
    "-0.0",
    ".nan",
    ".inf",
    "99999999999999999999",
    "1e6",
    "-7",
    "0x1F",
    "12:30",
)
VALUES = (
    "[]",
    "{}",
    "true",
    "~",
    "text",
    "[1, [2, [3]]]",
    "{a: {b: c}}",
    "''",
    "[1, 2, 3, 4, 5]",
    "1.5.2",
    "2026-01-01",
)
WEIRD = ("\u202e", "\u0000", "\u00a0", "\u2028", "\ufeff", "\U0001f681", "\u0660", "\u2212", "\u0301", "\u0085", "\t")
BROKEN = (
    "{",
    "[",
    "}",
    "]",
    ":",
    "- ",
    "'",
    '"',
    "&a",
    "*a",
    "!!python/object:os.system",
    "|",
    ">",
    "%",
    "@",
    "`",
    "---\n",
)
EXPRESSIONS = (
    "x.__class__", "().__class__.__bases__[0]", "__import__('os').system('true')", "x.real", "lambda: 1", "[x for x in y]",
    "x if y else z", "open('/etc/passwd')", "9**9**9**9", "((((((((((x))))))))))" * 3, "x**1e9", "1/0", "log(-1)", "sin()",
    "sin(x, y)", "atan2(x)", "x; y", "x = 3", "'a'", "f'{x}'", "x and y", "x < y", "~x", "x @ y", "s", "pi(3)", "abs",
    "x" * 5000, "+".join(["x"] * 3000), "(" * 400 + "x" + ")" * 400, "1e400", "\u03c0*x", "x\n+y",
)  # fmt: skip


def _line(change: Callable[[random.Random, list[str], int], None]) -> Mutation:
    def mutate(rng: random.Random, text: str) -> str:
        lines = text.split("\n")
        change(rng, lines, rng.randrange(len(lines)))
        return "\n".join(lines)

    return mutate


def _instead(pattern: re.Pattern[str], choose: Callable[[random.Random, re.Match[str]], str]) -> Mutation:
    """One of what ``pattern`` finds, replaced."""

    def mutate(rng: random.Random, text: str) -> str:
        found = list(pattern.finditer(text))
        if not found:
            return text
        match = rng.choice(found)
        return text[: match.start()] + choose(rng, match) + text[match.end() :]

    return mutate


def _misspelt(rng: random.Random, match: re.Match[str]) -> str:
    name = list(match.group(2))
    at = rng.randrange(len(name))
    rng.choice(
        (lambda: name.pop(at), lambda: name.insert(at, rng.choice("aeioxyz_")), lambda: name.__setitem__(at, "q"))
    )()
    return f"{match.group(1)}{''.join(name)}{match.group(3)}"


def _scaled(rng: random.Random, match: re.Match[str]) -> str:
    factor = rng.choice((1000.0, 0.001, 57.29578, 0.0174533, 3.28084, -1.0, 1e7, 100.0))
    return repr(float(match.group()) * factor)


def _anywhere(choices: tuple[str, ...]) -> Mutation:
    def mutate(rng: random.Random, text: str) -> str:
        at = rng.randrange(len(text) + 1)
        return text[:at] + rng.choice(choices) + text[at:]

    return mutate


VALUE = re.compile(r"(?<=: )[^\n#{\[]+(?=\n| #)")
MUTATIONS: dict[str, Mutation] = {
    "a line deleted": _line(lambda rng, lines, i: lines.pop(i) and None),
    "a line twice": _line(lambda rng, lines, i: lines.insert(i, lines[i])),
    "two lines swapped": _line(lambda rng, lines, i: lines.insert(rng.randrange(len(lines)), lines.pop(i))),
    "a line indented": _line(lambda rng, lines, i: lines.__setitem__(i, " " * rng.randrange(1, 5) + lines[i])),
    "a key misspelt": _instead(KEY, _misspelt),
    "another number": _instead(NUMBER, lambda rng, match: rng.choice(NUMBERS)),
    "another unit": _instead(NUMBER, _scaled),
    "another type": _instead(VALUE, lambda rng, match: rng.choice(VALUES)),
    "an expression": _instead(VALUE, lambda rng, match: rng.choice(EXPRESSIONS)),
    "broken syntax": _anywhere(BROKEN),
    "strange characters": _anywhere(WEIRD),
    "cut off": lambda rng, text: text[: rng.randrange(max(1, len(text)))],
    "a number in a list gone": _instead(re.compile(r"(?<=[\[,] )?-?\d+(?:\.\d+)?, "), lambda rng, match: ""),
    "a comma gone": _instead(re.compile(","), lambda rng, match: " "),
}
PLAN_NUMBERS = (
    "null",
    "NaN",
    "1e999",
    "-1",
    "0",
    '"7"',
    "1e300",
    "true",
    "[]",
    "{}",
    "65535",
    "95.5",
    "-200",
    "178",
    "177",
    "84",
)
PLAN_MUTATIONS: dict[str, Mutation] = {
    "another number": _instead(NUMBER, lambda rng, match: rng.choice(PLAN_NUMBERS)),
    "a line deleted": MUTATIONS["a line deleted"],
    "a line twice": MUTATIONS["a line twice"],
    "broken syntax": _anywhere(("{", "}", "[", "]", ",", ":", '"', "//", "\\", "nul")),
    "strange characters": MUTATIONS["strange characters"],
    "cut off": MUTATIONS["cut off"],
    "another key": _instead(re.compile(r'"[A-Za-z]+"(?=:)'), lambda rng, match: '"thing"'),
    "another word": _instead(
        re.compile(r'(?<=: )"[A-Za-z]+"'), lambda rng, match: rng.choice(('"ComplexItem"', '""', "7"))
    ),
}


def originals() -> list[tuple[str, str]]:
    """Name and text of every mission that is spoilt: those shipped and the examples of every kind."""
    shipped = [
        (name, (SHIPPED / "missions" / f"{name}.yaml").read_text(encoding="utf-8")) for name in names("missions")
    ]
    return shipped + [(f"new-{kind}", example(kind, "field.plan")) for kind in PATHS]


def cases(count: int, seed: int) -> list[tuple[str, str | None, str | None]]:
    """``count`` spoilt files: what was done to which, the mission's text (None for a plan given in the place of a
    mission), and the plan's text where it has one."""
    rng = random.Random(seed)
    missions = originals()
    found: list[tuple[str, str | None, str | None]] = []
    for i in range(count):
        if i % 5 == 4:
            what = rng.choice(list(PLAN_MUTATIONS))
            text = example_plan()
            for _ in range(rng.choice((1, 1, 2, 5))):
                text = PLAN_MUTATIONS[what](rng, text)
            found.append((f"plan: {what}", None, text))
            continue
        name, text = missions[i % len(missions)]
        what = list(MUTATIONS)[i % len(MUTATIONS)] if i < len(MUTATIONS) else rng.choice(list(MUTATIONS))
        for _ in range(rng.choice((1, 1, 2, 4))):
            text = MUTATIONS[what](rng, text)
        found.append((f"{name}: {what}", text, example_plan() if "plan" in name else None))
    return found


SOON = 3.0
"""s of a core."""


def outcome(mission: str | None, plan: str | None, folder: Path) -> tuple[str, str]:
    """What becomes of one: a word for the table, and what is said."""
    file = folder / ("field.plan" if mission is None else "field.yaml")
    if plan is not None:
        (folder / "field.plan").write_text(plan, encoding="utf-8", newline="")
    if mission is not None:
        file.write_text(mission, encoding="utf-8", newline="")
    try:
        found = check_sortie(read_sortie(str(file), None, Output.AUTO))[1]
    except ConfigError as error:
        lines = {"field.yaml": (mission or "").count("\n") + 2, "field.plan": (plan or "").count("\n") + 2}
        for fault in error.faults:
            name = Path(fault.file).name
            if name not in lines or not 1 <= fault.line <= lines[name] or not fault.message:
                return "WRONG LINE", str(fault)
        return "faults", str(error)
    except Exception:
        return "TRACEBACK", traceback.format_exc()
    return ("feasible" if found.feasible else "not feasible"), ""
