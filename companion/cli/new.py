"""``new``: a commented example of every kind of file; ``schema``: what an editor needs to know of them."""

from __future__ import annotations

import difflib
from pathlib import Path

from companion.cli.terminal import say
from companion.cli.writing import writable, write
from companion.config.examples import KINDS, example, example_plan
from companion.config.json_schemas import MODELS, schema_text
from companion.config.syntax.faults import ConfigError, Fault
from companion.library.faults import Faults


def new(kind: str, file: Path | None, force: bool) -> None:
    """Write the example. ConfigError: there is no such kind, or the file is there already."""
    _refuse_unknown("KIND", kind, KINDS)
    target = file if file is not None else Path(f"{kind}.yaml")
    plan = target.with_suffix(".plan")
    faults = Faults()
    faults.collect(lambda: writable("FILE", target, force))
    if kind == "plan":
        faults.collect(lambda: writable("FILE", plan, force))
    faults.raise_any()
    if kind == "plan":
        write(plan, example_plan())
        say(f"{plan}: a small plan, to be replaced by your own")
    write(target, example(kind, plan.name))
    say(f"{target}: written")
    if kind == "study":
        say(f"next: companion study run {target}")
    elif kind in MODELS:
        say(f"next: companion sim circle --{kind} {target}")
    else:
        say(f"next: companion check {target}; companion sim {target}")
    say(f"an editor shows every key after: companion schema {kind if kind in MODELS else 'mission'} > {_schema(kind)}")


def schema(kind: str) -> None:
    """Print the schema. ConfigError: there is no such kind."""
    _refuse_unknown("KIND", kind, tuple(MODELS))
    print(schema_text(kind), end="")


def _schema(kind: str) -> str:
    return f"{kind if kind in MODELS else 'mission'}.schema.json"


def _refuse_unknown(name: str, kind: str, kinds: tuple[str, ...]) -> None:
    if kind not in kinds:
        close = difflib.get_close_matches(kind, kinds, 1)
        hint = f"did you mean {close[0]}?" if close else f"expected one of {', '.join(kinds)}"
        raise ConfigError([Fault(name, 0, "", f"{kind!r} is not known; {hint}")])
