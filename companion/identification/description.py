"""A vehicle file in the making: every key with its value, where that is from, and how well it is known."""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from companion.plain_text import printable


class Source(enum.Enum):
    """Where a value is from; the word it has in the file."""

    PX4 = "PX4"
    LOG = "log"
    GIVEN = "given"
    ASSUMED = "MEASURE"
    USUAL = "usual"


MEANING = {
    Source.PX4: "as the autopilot holds it",
    Source.LOG: "found in a log, with its standard deviation",
    Source.GIVEN: "as you said, or as your file said before",
    Source.ASSUMED: "neither PX4 nor a log knows it: a guess, to be measured",
    Source.USUAL: "a usual value, good enough where nothing better is known",
}
"""What each of them promises to who reads the file."""


class Entry(NamedTuple):
    """One value of a vehicle file. ``words``: what it was made of, in a few words, with its unit."""

    value: Any
    source: Source
    words: str


KEYS = (
    "mass_kg", "inertia_kgm2", "gravity", "rotors", "motor_lag_s", "drag_per_s", "hover_thrust", "rate_loop_lag_s",
    "link_delay_s", "state_rate_hz", "motors", "limits",
)  # fmt: skip
"""The order of a vehicle file."""


@dataclass(frozen=True)
class Description:
    """A vehicle as far as it is known. ``origin``: lines on where all of it is from. ``entries``: by the keys of a
    vehicle file; a list or a mapping may be an entry of entries. ``notes``: what no key of a vehicle file holds."""

    name: str
    origin: tuple[str, ...]
    entries: Mapping[str, Any]
    notes: tuple[str, ...] = field(default=())

    @property
    def data(self) -> dict[str, Any]:
        """The values alone."""
        return {"name": self.name, **{key: _plain(self.entries[key]) for key in KEYS if key in self.entries}}

    @property
    def unmeasured(self) -> tuple[str, ...]:
        """The keys whose values are guesses."""
        return tuple(key for key in KEYS if key in self.entries and Source.ASSUMED in _sources(self.entries[key]))

    @property
    def text(self) -> str:
        """The vehicle file: YAML with a comment to every value."""
        lines = [f"# {printable(line)}" for line in self.origin]
        used = {source for key in self.entries for source in _sources(self.entries[key])}
        lines += [f"#   {source.value + ':':9}{MEANING[source]}" for source in Source if source in used]
        lines.append(f"name: {_scalar(self.name)}")
        for key in KEYS:
            if key in self.entries:
                lines += _lines(key, self.entries[key])
        lines += [f"# {printable(note)}".rstrip() for note in self.notes]
        return "\n".join(lines) + "\n"


_COMMENT = re.compile(rf"# ({'|'.join(source.value for source in Source)}): (.*)$")


def of_file(data: Mapping[str, Any], lines: Mapping[tuple[str | int, ...], int], text: str) -> Description:
    """A vehicle file that is there already, by what the comment on the line of each value says; what has none is its
    owner's. ``data``: what ``text`` holds; ``lines``: from 1, of every key and of every row of a list in it."""
    written = text.splitlines()

    def entry(value: Any, *key: str | int) -> Entry:
        told = _COMMENT.search(written[lines[key] - 1])
        return Entry(value, Source.GIVEN, "") if told is None else Entry(value, Source(told[1]), told[2])

    entries: dict[str, Any] = {}
    for name in (name for name in KEYS if name in data):
        value = data[name]
        if name == "rotors":
            entries[name] = [entry(row, name, i) for i, row in enumerate(value)]
        elif isinstance(value, Mapping):
            entries[name] = {inner: entry(each, name, inner) for inner, each in value.items()}
        elif value is not None:
            entries[name] = entry(value, name)
    return Description(str(data["name"]), (), entries)


def _lines(key: str, entry: Any) -> list[str]:
    """One key of a vehicle file."""
    if isinstance(entry, Entry):
        return [f"{key}: {_flow(entry.value)} # {_comment(entry)}"]
    if isinstance(entry, Mapping):
        return [f"{key}:", *(f"  {line}" for inner, value in entry.items() for line in _lines(inner, value))]
    return [f"{key}:", *(f"  - {_flow(row.value)} # {_comment(row)}" for row in entry)]


def _comment(entry: Entry) -> str:
    return printable(f"{entry.source.value}: {entry.words}").rstrip()


def _plain(entry: Any) -> Any:
    if isinstance(entry, Entry):
        return entry.value
    return {k: _plain(v) for k, v in entry.items()} if isinstance(entry, Mapping) else [_plain(each) for each in entry]


def _sources(entry: Any) -> set[Source]:
    if isinstance(entry, Entry):
        return {entry.source}
    return {s for each in (entry.values() if isinstance(entry, Mapping) else entry) for s in _sources(each)}


def _flow(value: Any) -> str:
    """A value on one line of YAML."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return f"{value:.4g}" if abs(value) < 1000.0 else f"{value:.6g}"
    text = str(value)
    return text if text.replace("-", "").replace("_", "").isalnum() and not text[:1].isdigit() else f'"{text}"'
