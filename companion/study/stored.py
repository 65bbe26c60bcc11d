"""The files of a study as JSON, and a study of them again: what is flown later is what was flown, wherever that is."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from companion.config.study.keys import StudyModel
from companion.config.syntax.document import parse
from companion.config.syntax.schema import validate
from companion.library.files import InputFile, MissionFile, as_yaml
from companion.record.folder import Source
from companion.study.reading import Study, study_of
from companion.study.variation import KINDS, Chosen

SCHEMA = "companion.study/1"


def files_text(study: Study) -> str:
    """Every file that the flights of a study begin from, as JSON."""
    usual = {"mission": study.mission, "vehicle": study.vehicle, "world": study.world}
    files = [{"kind": kind, "chosen": None, **_told(file)} for kind, file in usual.items()]
    files += [{"kind": kind, "chosen": name, **_told(file)} for (kind, name), file in study.chosen.items()]
    return json.dumps({"schema": SCHEMA, "files": files}, indent=2) + "\n"


def study_with(text: str, files: str) -> Study:
    """The study in ``text``, of ``files`` (JSON). ConfigError, ValueError, KeyError, TypeError: they are no such."""
    document = json.loads(files)
    if document["schema"] != SCHEMA:
        raise ValueError(f"files.json is {document['schema']}, expected {SCHEMA}")
    usual: dict[str, InputFile] = {}
    chosen = Chosen()
    for told in document["files"]:
        kind, name = str(told["kind"]), told["chosen"]
        if name is None:
            usual[kind] = _file(told)
        else:
            chosen[kind, str(name)] = _file(told)
    return study_of(validate(parse(text, "study.yaml"), StudyModel), usual, chosen, text)


@contextlib.contextmanager
def at_hand(mission: MissionFile) -> Iterator[MissionFile]:
    """A mission whose plan is on this machine's disk as it was when the study was read."""
    source = mission.source
    if source.attached is None:
        yield mission
        return
    name, text = source.attached
    file = str(mission.data["path"]["file"])
    if _reads(Path(source.name).parent / file, text):
        yield mission
        return
    with tempfile.TemporaryDirectory(prefix="companion-") as folder:
        (Path(folder) / name).write_text(text, encoding="utf-8")
        here = replace(source, name=str(Path(folder) / Path(source.name).name))
        if file != name:
            data = mission.data
            data["path"]["file"] = name
            here = replace(here, text=as_yaml(data), made=True)
        yield MissionFile(here)


def _reads(file: Path, text: str) -> bool:
    try:
        return file.read_text(encoding="utf-8") == text
    except (OSError, ValueError):
        return False


def _told(file: InputFile) -> dict[str, Any]:
    source = file.source
    return {"name": source.name, "text": source.text, "attached": source.attached, "made": source.made}


def _file(told: dict[str, Any]) -> InputFile:
    attached = told["attached"]
    beside = None if attached is None else (str(attached[0]), str(attached[1]))
    return KINDS[told["kind"]](Source(str(told["name"]), str(told["text"]), beside, bool(told["made"])))
