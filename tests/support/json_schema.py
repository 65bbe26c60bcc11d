"""Enough of JSON Schema to check a file against ours."""

from __future__ import annotations

from typing import Any

TYPES: dict[str, Any] = {
    "object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), "number": (int, float), "integer": int,
}  # fmt: skip


def wrong(schema: dict[str, Any], value: Any, root: dict[str, Any], at: str = "$") -> list[str]:
    """What is wrong with ``value``; nothing where it is as the schema says."""
    if "$ref" in schema:
        return wrong(root["$defs"][schema["$ref"].removeprefix("#/$defs/")], value, root, at)
    found: list[str] = []
    for name in ("anyOf", "oneOf"):
        if name in schema:
            results = [wrong(branch, value, root, at) for branch in schema[name]]
            fits = sum(not result for result in results)
            if fits == 0 or (name == "oneOf" and fits > 1):
                found.append(f"{at}: {fits} of {name}: {min(results, key=len)}")
    kinds = schema.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if kinds and not any(
        isinstance(value, TYPES[kind]) and not (isinstance(value, bool) and kind in ("number", "integer"))
        for kind in kinds
    ):
        return [*found, f"{at}: not {kinds}"]
    if "enum" in schema and value not in schema["enum"]:
        found.append(f"{at}: not in {schema['enum']}")
    if "const" in schema and value != schema["const"]:
        found.append(f"{at}: not {schema['const']}")
    if isinstance(value, int | float) and not isinstance(value, bool):
        found += [
            f"{at}: {name} {limit}"
            for name, limit, broken in (
                ("minimum", schema.get("minimum"), lambda limit: value < limit),
                ("maximum", schema.get("maximum"), lambda limit: value > limit),
                ("exclusiveMinimum", schema.get("exclusiveMinimum"), lambda limit: value <= limit),
                ("exclusiveMaximum", schema.get("exclusiveMaximum"), lambda limit: value >= limit),
            )
            if limit is not None and broken(limit)
        ]
    if isinstance(value, str | list):
        least = schema.get("minLength" if isinstance(value, str) else "minItems", 0)
        most = schema.get("maxLength" if isinstance(value, str) else "maxItems", 1e9)
        if not least <= len(value) <= most:
            found.append(f"{at}: {len(value)} of {least} to {most}")
    if isinstance(value, list) and "items" in schema:
        for i, part in enumerate(value):
            found += wrong(schema["items"], part, root, f"{at}[{i}]")
    if isinstance(value, dict):
        known = schema.get("properties", {})
        found += [f"{at}.{name}: missing" for name in schema.get("required", []) if name not in value]
        for name, part in value.items():
            more = schema.get("additionalProperties", True)
            if name in known:
                found += wrong(known[name], part, root, f"{at}.{name}")
            elif more is False:
                found.append(f"{at}.{name}: not known")
            elif isinstance(more, dict):
                found += wrong(more, part, root, f"{at}.{name}")
    return found
