"""Mission, vehicle and world files as values: read from the disk, made in Python, or changed key by key.

Whatever they come from, they are read by the same readers as the commands' files, so they give the same values and are
refused with the same sentences.
"""

from __future__ import annotations

import copy
import dataclasses
import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
import yaml

from companion.config.mission.mission import mission_from
from companion.config.plan.source import attached
from companion.config.syntax.document import scalar
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.vehicle import vehicle_from
from companion.config.world.world import world_from
from companion.library.orders import document_of, mission_document, source_of
from companion.mission import Mission
from companion.record.files import write_whole
from companion.record.folder import Source
from companion.vehicle import Vehicle
from companion.world import World

_PARTS = re.compile(r"\.|(?=\[)")


@dataclass(frozen=True)
class InputFile:
    """A file: its text, and what it says. Values, never changed: ``changed`` makes another one."""

    source: Source
    folder: ClassVar[str] = ""
    """Where in configs/ its kind lies."""

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another process: the text; what was made of it is made again where it is needed."""
        return {"source": self.source}

    @classmethod
    def load(cls, name: str | Path) -> Self:
        """The file of a name in configs/ or a path. ConfigError with every fault."""
        return cls(source_of(str(name), cls.folder)).checked()

    @classmethod
    def made(cls, name: str, data: Mapping[str, Any]) -> Self:
        """A file that holds ``data``; ``name``: what faults call it. ConfigError with every fault."""
        text = as_yaml(data)
        beside = attached(text, name) if cls.folder == "missions" else None
        return cls(Source(name, text, beside, made=True)).checked()

    @property
    def text(self) -> str:
        """As YAML."""
        return self.source.text

    @property
    def data(self) -> dict[str, Any]:
        """What it says, by the keys of its kind of file."""
        said: dict[str, Any] = copy.deepcopy(document_of(self.source).data)
        return said

    def changed(self, keys: Mapping[str, Any]) -> Self:
        """The same file with other values: ``changed({"path.constants.r": 8, "gains.poles.yaw": [-3]})``. A key may be
        new; the value None takes one away. ConfigError with every fault."""
        data = self.data
        for key, value in keys.items():
            _put(data, key, value, self.source.name)
        beside = self.source.attached
        text = as_yaml(data)
        if self.folder == "missions" and beside is None:
            beside = attached(text, self.source.name)
        return dataclasses.replace(self, source=Source(self.source.name, text, beside, made=True)).checked()

    def save(self, file: str | Path) -> Path:
        """Write it, for the commands and for an editor; over what is there."""
        write_whole(Path(file), self.text)
        return Path(file)

    def checked(self) -> Self:
        """Itself. ConfigError with every fault."""
        assert self.value is not None
        return self

    @property
    def value(self) -> Any:
        """What the software makes of it."""
        raise NotImplementedError


class MissionFile(InputFile):
    """A mission: a path, a speed and a heading along it. ``value``: as it is flown, without gains, which depend on the
    output."""

    folder = "missions"

    @cached_property
    def value(self) -> Mission:
        """The mission, its curve traced."""
        return mission_from(mission_document(self.source), None)

    @property
    def name(self) -> str:
        """As its file says."""
        return self.value.name

    @property
    def length(self) -> float:
        """m along the path, once."""
        return self.value.table.length


class VehicleFile(InputFile):
    """A quadrotor in the units of a data sheet."""

    folder = "vehicles"

    @cached_property
    def value(self) -> Vehicle:
        """The vehicle."""
        return vehicle_from(document_of(self.source))

    @property
    def name(self) -> str:
        """As its file says."""
        return self.value.name


class WorldFile(InputFile):
    """A simulated world: the air, the link, the true machine, and what happens."""

    folder = "worlds"

    @cached_property
    def value(self) -> World:
        """The world."""
        return world_from(document_of(self.source))

    @property
    def name(self) -> str:
        """As its file says."""
        return self.value.name


class _Dumper(yaml.SafeDumper):
    """Writes what ``config.syntax`` reads: no anchors, and text that looks like a number in quotes."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.Node:
    style = None if isinstance(scalar(text), str) else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent_text)


def as_yaml(data: Any) -> str:
    """A mapping of plain values, or of numpy's, as the text of a file."""
    return yaml.dump(plain(data), Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=110)


def plain(value: Any) -> Any:
    """Dicts, lists, text and numbers, whatever it was made with."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return str(value) if isinstance(value, Path | complex) else value


def _put(data: Any, key: str, value: Any, where: str) -> None:
    """Set what a key names; ``"rotors[1].spin"``."""
    parts: list[str | int] = [
        int(part[1:-1]) if part.startswith("[") and part[1:-1].isdigit() else part for part in _PARTS.split(key)
    ]
    at = data
    for part, following in itertools.pairwise(parts):
        if isinstance(at, dict) and isinstance(part, str) and at.get(part) is None:
            at[part] = {}
        at = _inner(at, part, key, where)
        if not isinstance(at, list if isinstance(following, int) else dict):
            raise _no_such(key, where)
    last = parts[-1]
    if isinstance(last, int):
        _inner(at, last, key, where)
        at[last] = value
    elif value is None:
        at.pop(last, None)
    else:
        at[last] = value


def _inner(at: Any, part: str | int, key: str, where: str) -> Any:
    if isinstance(part, int) and not 0 <= part < len(at):
        raise _no_such(key, where)
    return at[part]


def _no_such(key: str, where: str) -> ConfigError:
    return ConfigError(
        [Fault(where, 0, key, "leads nowhere; expected a key such as speed, path.radius or rotors[0].spin")]
    )
