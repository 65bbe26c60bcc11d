"""``export-flight``: a flight folder as files that other programs open."""

from __future__ import annotations

import time
from pathlib import Path

from companion.cli.export import writable, write
from companion.cli.terminal import busy, say
from companion.config.syntax.faults import ConfigError, Fault
from companion.library.orders import Faults


def export_flight(directory: Path, to: Path | None, *, csv: bool, mcap: bool, force: bool) -> None:
    """Write the files that were asked for. ConfigError: with every reason why they cannot be."""
    from companion.record.export.csv_files import csv_files
    from companion.record.export.folder import told_in
    from companion.record.export.mcap_file import write_mcap
    from companion.record.replay import load_flight

    folder = directory if to is None else to
    faults = Faults()
    if not csv and not mcap:
        faults.add(Fault("--csv", 0, "", "missing; expected --csv or --mcap, or both"))
    flight = faults.collect(lambda: load_flight(directory))
    packed = folder / "flight.mcap"
    if mcap:
        faults.collect(lambda: writable("--mcap", packed, force))
    names = ("flight.csv", "path.csv", "truth.csv", "columns.csv") if csv else ()
    for name in names:
        faults.collect(lambda name=name: writable("--csv", folder / name, force))  # type: ignore[misc]
    faults.raise_any()
    assert flight is not None
    for cut in flight.cuts:
        say(f"note: {cut}")
    begun = time.monotonic()
    if mcap:
        with busy("writing flight.mcap"):
            try:
                messages = write_mcap(packed, flight, told_in(directory))
            except OSError as error:
                raise ConfigError([Fault(str(packed), 0, "", f"cannot be written: {error.strerror}")]) from None
        say(f"{packed}: {messages} messages, {time.monotonic() - begun:.1f} s")
    if csv:
        with busy("writing flight.csv"):
            for name, text in csv_files(flight).items():
                write(folder / name, text)
                say(f"{folder / name}: {text.count(chr(10)) - 1} rows")
