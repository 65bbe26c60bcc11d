"""A vehicle file in the making: every key with its value, where that is from, and how well it is known."""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
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

    def with_entries(self, **entries: Any) -> Description:
        """The same with other entries."""
        return replace(self, entries={**self.entries, **entries})

    @property
    def data(self) -> dict[str, Any]:
        """The values alone."""
        return {"name": self.name, **{key: _plain(self.entries[key]) for key in KEYS if key in self.entries}}

    @property
    def unmeasured(self) -> tuple[str, ...]:
        """The keys whose values are guesses."""
        return tuple(key for key in KEYS if key in self.entries and _is_guess(self.entries[key]))

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


def of_file(data: Mapping[str, Any], text: str) -> Description:
    """A vehicle file that is there already, by what its comments say of every value; what they do not is its owner's.
    ``data``: what it holds."""
    told: dict[str, list[Entry]] = {}
    key = ""
    for line in text.splitlines():
        key = line.split(":")[0] if line[:1].isalpha() else key
        found = _COMMENT.search(line)
        if found is not None:
            told.setdefault(key, []).append(Entry(None, Source(found[1]), found[2]))

    def entry(name: str, value: Any, i: int = 0) -> Entry:
        comments = told.get(name, [])
        return comments[i]._replace(value=value) if i < len(comments) else Entry(value, Source.GIVEN, "")

    entries: dict[str, Any] = {}
    for name in KEYS:
        value = data.get(name)
        if name == "rotors":
            entries[name] = [entry(name, row, i) for i, row in enumerate(value or ())]
        elif isinstance(value, Mapping):
            entries[name] = {inner: entry(name, each, i) for i, (inner, each) in enumerate(value.items())}
        elif value is not None:
            entries[name] = entry(name, value)
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


def _is_guess(entry: Any) -> bool:
    return Source.ASSUMED in _sources(entry)


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
