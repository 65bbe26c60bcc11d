"""The files that every vehicle offers: the description of itself that ground stations look for."""

from __future__ import annotations

import json
import lzma
import zlib
from dataclasses import dataclass
from functools import cached_property

from sim_bridge.autopilot.commander.event_table import event_table
from sim_bridge.autopilot.parameters import table

GENERAL_METADATA_PATH = "etc/extras/component_general.json.xz"
GENERAL_METADATA_URI = f"mftp://{GENERAL_METADATA_PATH}"
PARAMETERS_PATH = "etc/extras/parameters.json.xz"
EVENTS_PATH = "etc/extras/all_events.json.xz"
DIRECTORIES = frozenset({"", "etc", "etc/extras", "log"})
"""Folders that are there without a file in them."""


@dataclass(frozen=True)
class Document:
    """A JSON document, packed with xz when it is first asked for."""

    content: object

    @cached_property
    def data(self) -> bytes:
        """The file as it is read."""
        text = json.dumps(self.content, separators=(",", ":"), sort_keys=True).encode("ascii")
        return lzma.compress(text, check=lzma.CHECK_CRC32, preset=6)

    @cached_property
    def crc(self) -> int:
        """CRC-32 of the file, as MAVLink's component metadata counts it."""
        return zlib.crc32(self.data)


@dataclass(frozen=True)
class _Parameters(Document):
    """The parameter description, which is made from the table."""

    content: object = None

    @cached_property
    def data(self) -> bytes:
        rows = [
            {"name": name, "type": _type(value), "default": value, "group": _group(name)}
            for name, value in table().items()
        ]
        return Document({"version": 1, "parameters": rows}).data


def _type(value: float) -> str:
    return "Int32" if isinstance(value, int) else "Float"


def _group(name: str) -> str:
    return name.split("_")[0].rstrip("0123456789") or name


PARAMETERS = _Parameters()
EVENTS = Document(event_table())
PARAMETER_METADATA = 1  # COMP_METADATA_TYPE_PARAMETER
EVENT_METADATA = 4  # COMP_METADATA_TYPE_EVENTS


class _General(Document):
    """The description that names the others."""

    @cached_property
    def data(self) -> bytes:
        entries = [
            {"type": PARAMETER_METADATA, "uri": f"mftp://{PARAMETERS_PATH}", "fileCrc": PARAMETERS.crc},
            {"type": EVENT_METADATA, "uri": f"mftp://{EVENTS_PATH}", "fileCrc": EVENTS.crc},
        ]
        return Document({"version": 1, "metadataTypes": entries}).data


GENERAL_METADATA = _General(None)
FILES: dict[str, Document] = {
    GENERAL_METADATA_PATH: GENERAL_METADATA,
    PARAMETERS_PATH: PARAMETERS,
    EVENTS_PATH: EVENTS,
}
"""Path without its leading slash -> file."""
