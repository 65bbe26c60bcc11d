"""The JSON Schema of each kind of file, for editors: every key, what it means, its unit."""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel

from companion.config.mission.mission import MissionModel
from companion.config.study.keys import StudyModel
from companion.config.vehicle import VehicleModel
from companion.config.world.keys import WorldModel

MODELS: dict[str, type[BaseModel]] = {
    "mission": MissionModel,
    "vehicle": VehicleModel,
    "world": WorldModel,
    "study": StudyModel,
}
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_text(kind: str) -> str:
    """The schema of a ``kind`` of file (mission, vehicle, world), as JSON."""
    schema = MODELS[kind].model_json_schema()
    head = {"$schema": DIALECT, "title": f"companion {kind}"}
    return json.dumps({**head, **_plain({k: v for k, v in schema.items() if k != "title"})}, indent=2) + "\n"


def editor_line(place: str) -> str:
    """The first line of a YAML file that tells editors where its schema is."""
    return f"# yaml-language-server: $schema={place}\n"


def _plain(node: Any, names: bool = False) -> Any:
    """Without what only Python knows: the titles made of names, the discriminators of OpenAPI, line breaks in texts.
    ``names``: the keys of ``node`` are names of keys in the file."""
    if isinstance(node, list):
        return [_plain(part) for part in node]
    if not isinstance(node, dict):
        return node
    plain = {}
    for key, value in node.items():
        if not names and key in ("title", "discriminator"):
            continue
        if not names and key == "description" and isinstance(value, str):
            value = value.replace("\n", " ")
        plain[key] = _plain(value, key in ("properties", "$defs"))
    return plain
