"""A flight that was flown, in simulation or not: its figures, its table, its report; read when asked for."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from companion.library.signals import Signals
    from companion.record.report.evidence import Evidence
    from companion.record.table import Table

_UNITS = ("s", "m", "m/s", "m/s^2", "rad", "rad/s", "N", "N/s", "Hz", "1/s")


class Flight:
    """A flight folder, read. ``folder``: where it lies; one that nobody asked for goes with the flight."""

    def __init__(self, folder: Path, temporary: TemporaryDirectory[str] | None = None) -> None:
        self.folder = folder
        self._temporary = temporary

    @classmethod
    def load(cls, folder: str | Path) -> Flight:
        """The flight in a folder. ConfigError: it is not one, or lacks a part."""
        flight = cls(Path(folder))
        assert flight._evidence.figures is not None
        return flight

    def __repr__(self) -> str:
        figures = self.summary
        error = figures.get("truth", figures)["settled"]["path_error_m"]["rms"]
        settled = "" if error is None else f", path error {100.0 * error:.2f} cm rms settled"
        what = f"{figures['mission']} on {figures['vehicle']} at {figures['output']}"
        return f"<Flight {what}: {figures['outcome']}{settled}>"

    @cached_property
    def _evidence(self) -> Evidence:
        from companion.record.report.evidence import read_evidence

        return read_evidence(self.folder)

    @property
    def summary(self) -> dict[str, Any]:
        """The figures (``companion.flight/1``)."""
        return self._evidence.figures

    @property
    def completed(self) -> bool:
        """Whether the mission was flown as it was asked for."""
        return bool(self.summary["outcome"] == "completed")

    @property
    def table(self) -> Table:
        """One row a tick, one named column a quantity: ``table["path_error"]``. See ``units`` and ``meanings``."""
        return self._evidence.table

    @property
    def truth(self) -> Table | None:
        """The plant's true state; None where a vehicle flew."""
        return self._evidence.truth

    @cached_property
    def meanings(self) -> dict[str, str]:
        """What each column of ``table`` is, in words, its unit first."""
        from companion.record.tick_columns import COLUMNS

        return {column.name: column.meaning for column in COLUMNS}

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column of ``table``; empty where it has none."""
        first = {name: meaning.split(" ")[0].rstrip(",") for name, meaning in self.meanings.items()}
        return {name: unit if unit in _UNITS else "" for name, unit in first.items()}

    @property
    def followed(self) -> dict[str, NDArray[np.float64]]:
        """The part that follows the path, one array a quantity: ``t`` (s of following), path_error, speed_error, ..."""
        return self._evidence.estimated

    @property
    def followed_truth(self) -> dict[str, NDArray[np.float64]] | None:
        """The same by the plant's true state, where the vehicle may believe something else; None where a vehicle flew.
        ``since``: s of following."""
        return self._evidence.true

    @cached_property
    def xi(self) -> Signals:
        """h1, h1', ... over time. CompanionError: the path is a curve, which has no h1 and h2."""
        from companion.library.signals import xi_of

        return xi_of(self._evidence.plan, self.followed)

    @cached_property
    def u(self) -> Signals:
        """What the vehicle was told over time."""
        from companion.library.signals import u_of

        return u_of(self._evidence.plan, self.followed)

    def to_csv(self, file: str | Path) -> Path:
        """Write the table as CSV, its first line the names of the columns."""
        import csv

        with Path(file).open("w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out)
            writer.writerow(self.table.dtype.names or ())
            writer.writerows(self.table.tolist())
        return Path(file)

    def to_pandas(self) -> Any:
        """The table as a pandas DataFrame. CompanionError: pandas is not installed."""
        from companion.vehicle import CompanionError

        try:
            import pandas
        except ImportError:
            raise CompanionError("a DataFrame needs pandas: pip install pandas") from None
        import numpy as np

        return pandas.DataFrame({name: np.asarray(self.table[name]) for name in self.table.dtype.names or ()})

    def report(self) -> Path:
        """Write the page ``report.html`` into the flight folder. CompanionError: matplotlib is not installed."""
        from companion.record.report import write_report

        return write_report(self.folder)

    def save(self, folder: str | Path) -> Flight:
        """The same flight in a folder of its own, new or empty. ConfigError: it is neither."""
        import shutil

        from companion.record.place import refuse_used

        refuse_used(Path(folder))
        shutil.copytree(self.folder, folder, dirs_exist_ok=True)
        return Flight(Path(folder))
