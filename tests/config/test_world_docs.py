"""docs/worlds.md names every key of a world file, with the words of the reader itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from companion.config.syntax.document import parse
from companion.config.syntax.file_lookup import names
from companion.config.syntax.schema import Strict
from companion.config.world import actor_keys, event_keys, keys, link_event_keys
from companion.config.world.world import load_world, world_from

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "worlds.md").read_text(encoding="utf-8")
OF_THEIR_OWN = ("LinkModel", "NoiseModel", "OnLink")
"""Models without a table: what they hold has one."""


def default_of(field: Any) -> str:
    if field.default_factory is not None:
        made = field.default_factory()
        return "none" if isinstance(made, BaseModel) or made == [] else f"`{made}`".replace(".0", "")
    if field.default is PydanticUndefined:
        return "needed"
    if field.default is None:
        return "none"
    return f"`{field.default:g}`" if isinstance(field.default, float) else f"`{field.default}`"


def table(model: type[BaseModel]) -> str:
    """The table of a model's keys, an event's under its kind."""
    kind = model.model_fields.get("kind")
    title = "" if kind is None else f"### {kind.annotation.__args__[0]}\n\n{(model.__doc__ or '').strip()}\n\n"  # type: ignore[union-attr]
    rows = "".join(
        f"| `{name}` | {' '.join((field.description or '').split())} | {default_of(field)} |\n"
        for name, field in model.model_fields.items()
        if name != "kind"
    )
    return f"{title}| key | | default |\n|---|---|---|\n{rows}"


def models() -> list[type[BaseModel]]:
    modules = (event_keys, link_event_keys, actor_keys, keys)
    found = [each for module in modules for each in vars(module).values() if isinstance(each, type)]
    own = {module.__name__ for module in modules}
    return [m for m in found if issubclass(m, Strict) and m.__module__ in own and not m.__name__.startswith("_")]


@pytest.mark.parametrize("model", [m for m in models() if m.__name__ not in OF_THEIR_OWN], ids=lambda m: m.__name__)
def test_the_page_has_the_readers_own_table(model: type[BaseModel]) -> None:
    assert table(model) in PAGE, f"docs/worlds.md should have:\n{table(model)}"


def test_the_pages_example_is_a_world() -> None:
    example = PAGE.split("```yaml\n")[1].split("```")[0]
    assert len(world_from(parse(example, "example")).events) == 2


@pytest.mark.parametrize("name", sorted(names("worlds")))
def test_the_page_tells_of_every_shipped_world(name: str) -> None:
    assert f"| `{name}` | " in PAGE
    assert load_world(name).name == name
