"""Whether every key that varies leads somewhere, and its ends may be flown."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from companion.calculus.expression import ExpressionError, parse
from companion.config.study.keys import VaryModel
from companion.config.syntax.document import Document
from companion.config.syntax.faults import ConfigError, Fault
from companion.library.files import InputFile, MissionFile, VehicleFile, WorldFile
from companion.study.sampling import completed, ends_of

KINDS: dict[str, type[InputFile]] = {"mission": MissionFile, "vehicle": VehicleFile, "world": WorldFile}
OF_A_FLIGHT = ("output", "seed", "duration", "settle")
_NAME = re.compile(r"[^\W\d]\w*")
Chosen = dict[tuple[str, str], InputFile]
"""The files that a choice names, by kind and name."""


def file_of(kind: str, name: str, beside: Path) -> InputFile:
    """The file of a name in configs/, or a path seen from the study's file. ConfigError with every fault."""
    path = Path(name)
    is_path = path.suffix or len(path.parts) != 1
    return KINDS[kind].load(beside / path if is_path else name)


def inner_keys(values: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """What of a flight's values is changed in a file of this kind."""
    return {key.removeprefix(f"{kind}."): value for key, value in values.items() if key.startswith(f"{kind}.")}


def check_variation(document: Document, files: dict[str, InputFile], faults: list[Fault]) -> Chosen:
    """The files that are chosen among; what is wrong with the keys of ``vary`` is added."""
    given = document.data.get("vary")
    models: dict[str, VaryModel] = {}
    for key, each in given.items() if isinstance(given, dict) else ():
        try:
            models[key] = VaryModel.model_validate(each)
        except ValidationError:
            continue  # said already
    checked = _Variation(document, files, models, faults)
    if isinstance(given, dict):
        checked.names(given)
    checked.formulas()
    return checked.ends()


class _Variation:
    """Looks at ``models``, by their keys; what is wrong goes into ``faults``."""

    def __init__(
        self, document: Document, files: dict[str, InputFile], models: dict[str, VaryModel], faults: list[Fault]
    ) -> None:
        self._document, self._files, self._models, self._faults = document, files, models, faults
        self._formulas = {key: model.formulas for key, model in models.items() if model.formulas}
        self._own = [key for key in models if key.isidentifier() and key not in KINDS and key not in self._formulas]

    def names(self, given: Mapping[str, Any]) -> None:
        """Every key is one that may vary."""
        used = {name for texts in self._formulas.values() for text in texts for name in _NAME.findall(text)}
        for key in given:
            kind, _, inner = key.partition(".")
            if (kind == "flight" and inner in OF_A_FLIGHT) or kind in KINDS or (key in self._own and key in used):
                continue
            expected = [*KINDS, *(f"{each}.KEY" for each in KINDS), *(f"flight.{each}" for each in OF_A_FLIGHT)]
            self._fault(key, f"is not known; expected {', '.join(expected)}, or a name that a formula uses")

    def formulas(self) -> None:
        """Every formula is one, of names that are there; the others are forgotten."""
        for key, texts in list(self._formulas.items()):
            try:
                for text in texts:
                    parse(text, self._own)
            except ExpressionError as error:
                self._fault(key, str(error))
                del self._formulas[key], self._models[key]

    def ends(self) -> Chosen:
        """Each key alone at its ends; where that cannot be flown, with the others at their first ones."""
        chosen, before, ends = Chosen(), len(self._faults), self._ends()
        firsts = {key: values[0] for key, values in ends.items()}
        for key, values in ends.items():
            kind, _, inner = key.partition(".")
            if kind not in self._files:
                continue
            for value in values:
                try:
                    if inner:
                        self._alone_or_with_others(kind, inner, value, firsts | {key: value})
                    else:
                        chosen[kind, str(value)] = file_of(kind, str(value), Path(self._document.file).parent)
                except ConfigError as error:
                    for fault in error.faults:
                        self._fault(key, _said(fault, inner))
                    break
        if len(self._faults) == before:
            self._together(firsts)
        return chosen

    def _ends(self) -> dict[str, list[Any]]:
        """The values that stand for all of each key."""
        ends = {key: ends_of(model) for key, model in self._models.items() if key not in self._formulas}
        first = {key: values[0] for key, values in ends.items()}
        for key in self._formulas:
            try:
                ends[key] = [completed({key: self._models[key]}, first)[key]]
            except (ValueError, ArithmeticError, TypeError) as error:
                self._fault(key, f"makes no number: {error}")
        return ends

    def _alone_or_with_others(self, kind: str, inner: str, value: Any, values: Mapping[str, Any]) -> None:
        try:
            self._files[kind].changed({inner: value})
        except ConfigError:
            try:
                self._files[kind].changed(inner_keys(values, kind))
            except ConfigError:
                pass
            else:
                return
            raise

    def _together(self, firsts: Mapping[str, Any]) -> None:
        """What has a name of its own, at both ends, with all that formulas make of it; first of all everything at its
        first end, which is said once if it is wrong."""
        pairs = [(name, value) for name in self._own for value in ends_of(self._models[name])]
        told: set[str] = set()
        for number, (name, value) in enumerate(pairs):
            if name in told or (number and value == firsts[name]):
                continue
            for message in self._wrong({**firsts, name: value}):
                told.add(name)
                self._fault(name, f"at {_shown(value)}, {message}")
            if told and not number:
                return

    def _wrong(self, values: Mapping[str, Any]) -> list[str]:
        """What is wrong with the files that a flight of these values makes."""
        try:
            made = completed(self._models, values)
            for kind, file in self._files.items():
                if any(key.startswith(f"{kind}.") for key in self._formulas):
                    file.changed(inner_keys(made, kind))
        except ConfigError as error:
            return [_said(fault, "") for fault in error.faults]
        except (ValueError, ArithmeticError, TypeError) as error:
            return [f"a formula makes no number: {error}"]
        return []

    def _fault(self, key: str, message: str) -> None:
        self._faults.append(self._document.fault(("vary", key), message))


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _said(fault: Fault, inner: str) -> str:
    return fault.message if not fault.key or fault.key == inner else f"{fault.key}: {fault.message}"
