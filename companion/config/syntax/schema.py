"""Plain data -> a pydantic model, or every fault at once, each in the words of the file's own keys."""

from __future__ import annotations

import difflib
import typing
from collections.abc import Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from companion.config.syntax.document import Document
from companion.config.syntax.faults import ConfigError, Fault, Key
from companion.config.syntax.units import unit_hint


class Strict(BaseModel):
    """The base of every file model: unknown keys are faults, numbers are finite, text is not silently a number."""

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


M = TypeVar("M", bound=BaseModel)


def validate(document: Document, model: type[M]) -> M:
    """The document as ``model``. ConfigError with every fault."""
    if not isinstance(document.data, dict):
        found = "empty" if document.data is None else f"a {_kind(document.data)}"
        raise ConfigError([document.fault((), f"the file is {found}; expected keys such as {_some_keys(model)}")])
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        raise ConfigError([_fault(document, model, details) for details in _once(document, error.errors())]) from None


_OF_ANOTHER_KIND = frozenset({"literal_error", "string_type", "float_type", "list_type", "model_type", "dict_type"})
"""What a value that may be of several kinds is told of those it is not of."""


def _once(document: Document, errors: Sequence[ErrorDetails]) -> list[ErrorDetails]:
    """One error a value: of what a value may be, the kind that it nearly is."""
    keyed = [(_key_in(document, details["loc"], details["type"] == "missing"), details) for details in errors]
    kept: dict[Key, ErrorDetails] = {}
    rest = []
    for key, details in keyed:
        if details["type"] not in _OF_ANOTHER_KIND:
            rest.append(details)
        elif not any(other[: len(key)] == key and d["type"] not in _OF_ANOTHER_KIND for other, d in keyed) and (
            key not in kept or (details["type"] == "literal_error") is isinstance(details["input"], str)
        ):
            kept[key] = details
    return [*rest, *kept.values()]


def _some_keys(model: type[BaseModel]) -> str:
    return ", ".join(list(_fields(model))[:4])


def _kind(value: Any) -> str:
    return {dict: "mapping", list: "list", str: "text", bool: "true/false value", type(None): "empty value"}.get(
        type(value), "number"
    )


def _printable(value: Any) -> str:
    text = "nothing" if value is None else repr(value) if isinstance(value, str) else str(value)
    text = text.lower() if isinstance(value, bool) else text
    return text if len(text) <= 60 else text[:57] + "..."


def _fault(document: Document, model: type[BaseModel], details: ErrorDetails) -> Fault:
    key = _key_in(document, details["loc"], details["type"] == "missing")
    expected = _description(model, details["loc"])
    given = _printable(details["input"])
    context = details.get("ctx", {})
    match details["type"]:
        case "missing":
            return document.fault(key, f"missing; expected {expected or 'a value'}")
        case "extra_forbidden":
            siblings = _siblings(model, details["loc"])
            given_key = str(key[-1])
            close = [name for name in siblings if name.startswith(f"{given_key}_")] or difflib.get_close_matches(
                given_key, siblings, 1, cutoff=0.6
            )
            hint = f"did you mean {close[0]}?" if close else f"expected one of {', '.join(siblings)}"
            return document.fault(key, f"unknown key; {hint}")
        case "value_error" | "assertion_error":
            return document.fault(key, str(context["error"]))
        case "literal_error" | "enum":
            return document.fault(key, f"{given} is not known; expected {context['expected']}")
        case "union_tag_invalid":
            tag = _printable(context["tag"])
            return document.fault((*key, "kind"), f"{tag} is not known; expected {context['expected_tags']}")
        case "union_tag_not_found":
            return document.fault((*key, "kind"), f"missing; expected {expected or 'the kind'}")
        case "too_short":
            wrong, wanted = f"{context['actual_length']} of them", f"at least {context['min_length']}"
            return document.fault(key, f"{wrong}; expected {wanted}{_also(expected)}")
        case "too_long":
            wrong, wanted = f"{context['actual_length']} of them", f"at most {context['max_length']}"
            return document.fault(key, f"{wrong}; expected {wanted}{_also(expected)}")
    wrong, wanted = _wrong_and_wanted(key, details, context)
    wanted_text = f"; expected {wanted}{_also(expected)}" if wanted else f"; expected {expected}" if expected else ""
    return document.fault(key, f"{given} is {wrong}{wanted_text}")


def _wrong_and_wanted(key: Key, details: ErrorDetails, context: dict[str, Any]) -> tuple[str, str]:
    """What a value is, and what it should be."""
    match details["type"]:
        case "greater_than":
            return "too small", f"more than {context['gt']:g}"
        case "greater_than_equal":
            return "too small", f"at least {context['ge']:g}"
        case "less_than":
            return f"too large{unit_hint(key, details['input'], context['lt'])}", f"less than {context['lt']:g}"
        case "less_than_equal":
            return f"too large{unit_hint(key, details['input'], context['le'])}", f"at most {context['le']:g}"
        case "finite_number":
            return "not finite", "a finite number"
        case "float_type" | "float_parsing" | "int_type" | "int_from_float":
            if details["type"] == "int_from_float" or (
                details["type"] == "int_type" and isinstance(details["input"], float)
            ):
                return "not a whole number", "a whole number"
            return "not a number", "a number"
        case "string_too_short":
            return "too short", "text"
        case "string_too_long":
            return "too long", f"at most {context['max_length']} characters"
        case "string_type":
            return "not text", "text"
        case "bool_type":
            return "neither true nor false", "true or false"
        case "list_type" | "tuple_type":
            return "not a list", "a list"
        case "model_type" | "dict_type" | "model_attributes_type":
            return "not a mapping", "keys and values"
        case _:
            return details["msg"].lower(), ""


def _also(expected: str) -> str:
    return f": {expected}" if expected else ""


def _key_in(document: Document, loc: tuple[str | int, ...], missing: bool) -> Key:
    """The part of pydantic's location that is keys of the file; pydantic also puts union branches in it."""
    key: Key = ()
    for part in loc:
        absent = missing and part == loc[-1] and isinstance(part, str) and isinstance(_at(document.data, key), dict)
        if absent or (*key, part) in document.lines:
            key = (*key, part)
    return key


def _at(data: Any, key: Key) -> Any:
    for part in key:
        data = data[part]
    return data


def _walk(model: Any, loc: tuple[str | int, ...]) -> tuple[type[BaseModel] | None, str]:
    """The innermost model on the way to ``loc``, and the description of the field ``loc`` names."""
    holder: type[BaseModel] | None = model
    description = ""
    current: list[type[BaseModel]] = [model]
    for part in loc:
        field = None
        for candidate in current:
            fields = _fields(candidate)
            if isinstance(part, str) and part in fields:
                holder, field = candidate, fields[part]
                break
        if field is not None:
            description = (field.description or "").strip().rstrip(".").replace("\n", " ")
            current = _models_in(field.annotation)
        elif isinstance(part, str):
            tagged = [c for c in current if _tag(c) == part or c.__name__ == part]
            if tagged:
                current, holder = tagged, tagged[0]
    return (current[0] if len(current) == 1 else holder), description


def _tag(model: type[BaseModel]) -> str | None:
    field = model.model_fields.get("kind")
    arguments = typing.get_args(field.annotation) if field is not None else ()
    return arguments[0] if arguments else None


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in typing.get_args(annotation) for model in _models_in(argument)]


def _description(model: type[BaseModel], loc: tuple[str | int, ...]) -> str:
    return _walk(model, loc)[1]


def _siblings(model: type[BaseModel], loc: tuple[str | int, ...]) -> list[str]:
    holder, _ = _walk(model, loc[:-1])
    return list(_fields(holder)) if holder is not None else []


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The fields by their keys in a file: `from` cannot be a name in Python."""
    return {field.alias or name: field for name, field in model.model_fields.items()}
