"""Which topics a PX4 takes and gives over XRCE, in which order, in which version of their messages."""

from __future__ import annotations

import enum
from functools import cache
from pathlib import Path
from typing import NamedTuple

from companion.xrce.topics import Topic

FIRST_READER = 0x800
"""The number of the first topic that is taken; the others follow in the order of the table."""


class Release(enum.Enum):
    """Whose table."""

    V1_15 = "1.15"
    V1_16 = "1.16"
    MAIN = "main"


class Row(NamedTuple):
    """A topic, the name of its message's type, its objects' number; if it is given, how often at most (Hz)."""

    topic: Topic
    type_name: str
    number: int
    rate: float


class TopicTable(NamedTuple):
    """``taken`` and ``given`` in the order in which the client makes them. ``waits_first``: for its clock, before."""

    taken: tuple[Row, ...]
    given: tuple[Row, ...]
    waits_first: bool


@cache
def table_of(release: Release) -> TopicTable:
    """The table of a release."""
    path = Path(__file__).with_name(f"topics_{release.value.replace('.', '_')}.txt")
    rows = [line.split() for line in path.read_text(encoding="ascii").splitlines() if not line.startswith("#")]
    taken = [
        _row(row, FIRST_READER + place, 0.0) for place, row in enumerate(row for row in rows if row[0] == "in")
    ]  # fmt: skip
    given = [_row(row, int(row[5], 16), float(row[4])) for row in rows if row[0] == "out"]
    return TopicTable(tuple(taken), tuple(given), waits_first=release is not Release.V1_15)


def _row(row: list[str], number: int, rate: float) -> Row:
    way, name, message, version = row[:4]
    return Row(Topic(name, int(version), way == "in"), f"px4_msgs::msg::dds_::{message}_", number, rate)
