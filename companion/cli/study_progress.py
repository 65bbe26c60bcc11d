"""A bar with the time left, on stderr; nothing where stderr is no terminal."""

from __future__ import annotations

import sys
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar


class Progress:
    """``step`` once a flight."""

    def __init__(self, flights: int) -> None:
        columns = TextColumn("flights"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        console = Console(file=sys.stderr)
        self._bar = Bar(*columns, console=console, disable=not console.is_terminal)
        self._task = self._bar.add_task("flights", total=flights)

    def step(self, new: bool) -> None:
        """One landed; ``new``: it was not there before."""
        self._bar.advance(self._task, 1 if new else 0)

    def __enter__(self) -> Progress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()
