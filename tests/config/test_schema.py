"""The published schemas and the examples: equal to the models, complete, and true."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.cli.new import new
from companion.config.examples import KINDS, OPEN, PATHS, example
from companion.config.json_schemas import MODELS, editor_line, schema_text
from companion.config.mission.mission import load_mission
from companion.config.syntax.document import parse
from companion.config.syntax.faults import ConfigError
from companion.config.syntax.file_lookup import SHIPPED, names
from companion.config.vehicle import load_vehicle
from companion.config.world.world import load_world
from companion.feasibility.report import check
from companion.law.gains import Level
from companion.study.flying import cases_of
from companion.study.reading import load_study
from tests.support.json_schema import wrong

ROOT = Path(__file__).resolve().parents[2]
UNIT = re.compile(
    r"\b(m|m/s|m\^2|s|kg|kg m\^2|N|N s\^2|N m|Hz|1/s|1/m|m/s\^2|degrees|degrees per second|deg/s|mAh|ohm|A|V|rad/s|no unit)\b"
    r"|0\.\.1|0 to 1|-1\.\.1|no unit|whole numbers|how many|over the vehicle file's|in ms|share"
)


def keys(schema: Any, at: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every key of every mapping, with its schema."""
    if isinstance(schema, list):
        for part in schema:
            yield from keys(part, at)
    elif isinstance(schema, dict):
        for name, part in schema.get("properties", {}).items():
            yield f"{at}.{name}", part
            yield from keys(part, f"{at}.{name}")
        for name, part in schema.items():
            if name == "$defs":
                for model, definition in part.items():
                    yield from keys(definition, model)
            elif name != "properties":
                yield from keys(part, at)


def is_a_number(schema: Any) -> bool:
    """Whether a number may stand here, alone or in a list, and nothing but null beside it."""
    if schema.get("type") in ("number", "integer"):
        return True
    if schema.get("type") == "array":
        return is_a_number(schema.get("items", {}))
    parts = [part for name in ("anyOf", "oneOf") for part in schema.get(name, []) if part.get("type") != "null"]
    return bool(parts) and all(map(is_a_number, parts))


@pytest.mark.parametrize("kind", MODELS)
def test_the_published_schema_is_the_models(kind: str) -> None:
    published = ROOT / "schema" / f"{kind}.schema.json"
    assert published.read_text() == schema_text(kind), f"write it again: companion schema {kind} > {published}"


@pytest.mark.parametrize("kind", MODELS)
def test_every_key_has_a_description_and_every_number_a_unit(kind: str) -> None:
    schema = json.loads(schema_text(kind))
    found = list(keys(schema))
    assert len(found) > 15
    for key, part in found:
        assert part.get("description"), key
        if is_a_number(part):
            assert UNIT.search(part["description"]), f"{key}: {part['description']}"


@pytest.mark.parametrize("file", sorted(SHIPPED.rglob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_files_name_their_schema_and_keep_it(file: Path) -> None:
    kind = "study" if file.parent.name == "studies" else file.parent.name[:-1]
    text = file.read_text()
    assert text.startswith(editor_line(f"../../schema/{kind}.schema.json")), (
        "its first line tells editors of the schema"
    )
    schema = json.loads(schema_text(kind))
    assert wrong(schema, parse(text, file.name).data, schema) == []


def test_the_schema_finds_what_the_models_find() -> None:
    schema = json.loads(schema_text("mission"))
    text = (SHIPPED / "missions" / "circle.yaml").read_text()
    for old, new_text in (("radius: 6", "radius: -6"), ("radius", "radus"), ("frame: enu", "frame: up"), ("speed: 4.0", "speed: []"),
                          ("[0, 0, 12]\n  r", "[0, 12]\n  r"), ("kind: circle", "kind: square")):  # fmt: skip
        assert new_text not in text
        assert wrong(schema, parse(text.replace(old, new_text), "m").data, schema), new_text
    place = text.replace("center: [0, 0, 12]", "center: {lat: 47.1, lon: 8.5, above_home: 12}")
    assert wrong(schema, parse(place, "m").data, schema) == []


@pytest.mark.parametrize("kind", KINDS)
def test_examples_can_be_flown_and_name_every_key(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    new(kind, file, force=False)
    text = file.read_text()
    model = kind if kind in MODELS else "mission"
    schema = json.loads(schema_text(model))
    assert wrong(schema, parse(text, "mine.yaml").data, schema) == []
    for name in schema["properties"]:
        not_here = "laps" if kind in OPEN else "repeat", "rotate_deg" if kind == "plan" else ""
        assert name in not_here or re.search(rf"^(# )?{name}:", text, re.MULTILINE), name
    if kind == "vehicle":
        load_vehicle(str(file))
    elif kind == "world":
        load_world(str(file))
    elif kind == "study":
        assert len(cases_of(load_study(file))) == 32
    else:
        assert check(load_mission(str(file), Level.RATES), load_vehicle("x500")).feasible
        used = schema["$defs"][f"{kind.capitalize()}Model"]["properties"]
        assert all(re.search(rf"^  (# )?{name}:", text, re.MULTILINE) for name in used)
    with pytest.raises(ConfigError, match="--force"):
        new(kind, file, force=False)
    new(kind, file, force=True)


def test_examples_of_what_may_stand_instead_are_right() -> None:
    """Each commented line, taken in the place of what it comments on."""
    for line in re.findall(
        r"^# ((?:speed|yaw|gains|origin|rotate_deg|laps|repeat): .*)$", example("spline"), re.MULTILINE
    ):
        key = line.split(":")[0]
        kept = [text for text in example("spline").splitlines() if not text.startswith(f"{key}:")]
        kept = [text for text in kept if key != "repeat" or not text.startswith("laps")]
        document = parse("\n".join([*kept, line]), "m.yaml")
        from companion.config.mission.mission import mission_from

        mission_from(document, Level.RATES)


def test_what_is_asked_for_wrongly(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="did you mean spline"):
        new("splin", tmp_path / "x.yaml", force=False)
    with pytest.raises(ConfigError, match="no such folder"):
        new("spline", tmp_path / "none" / "x.yaml", force=False)
    assert set(PATHS) == {load_kind(name) for name in names("missions")} | {"plan", "implicit"}


def load_kind(name: str) -> str:
    kind: str = parse((SHIPPED / "missions" / f"{name}.yaml").read_text(), name).data["path"]["kind"]
    return kind
