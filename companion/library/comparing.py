"""Two flights side by side, figure by figure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from companion.library.flights import Flight

PARTS = ("follow", "settled", "truth", "loop")


class Compared(NamedTuple):
    """One figure of both flights; None where a flight has none. ``name``: its keys in the summary, with dots."""

    name: str
    a: float | None
    b: float | None

    @property
    def ratio(self) -> float | None:
        """b over a; None where there is no such number."""
        return None if self.a is None or self.b is None or self.a == 0.0 else self.b / self.a


@dataclass(frozen=True)
class Comparison:
    """``comparison["truth.settled.path_error_m.rms"].ratio``; printed, it is a table."""

    a: Flight
    b: Flight
    rows: tuple[Compared, ...]

    def __getitem__(self, name: str) -> Compared:
        """The figure of this name. KeyError: neither flight has it."""
        for row in self.rows:
            if row.name == name:
                return row
        raise KeyError(name)

    def __str__(self) -> str:
        lines = [f"a: {self.a!r}", f"b: {self.b!r}", f"{'':40}{'a':>14}{'b':>14}{'b/a':>10}"]
        return "\n".join(
            [*lines, *(f"{row.name:40}{_cell(row.a, 14)}{_cell(row.b, 14)}{_cell(row.ratio, 10)}" for row in self.rows)]
        )


def compared(a: Flight, b: Flight) -> Comparison:
    """Every number of both summaries that describes how the path was flown."""
    of_a, of_b = dict(figures_of(a.summary)), dict(figures_of(b.summary))
    names = [*of_a, *(name for name in of_b if name not in of_a)]
    return Comparison(a, b, tuple(Compared(name, of_a.get(name), of_b.get(name)) for name in names))


def figures_of(summary: dict[str, Any], parts: tuple[str, ...] = PARTS) -> Iterator[tuple[str, float]]:
    """The numbers of a summary by their keys, joined with dots."""
    for part in parts:
        yield from _numbers(part, summary.get(part))


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(f"{name}.{key}", inner)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name, float(value)


def _cell(value: float | None, width: int) -> str:
    return f"{'-':>{width}}" if value is None else f"{value:>{width}.4g}"
