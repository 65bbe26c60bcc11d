"""``export-flight``: a flight folder as files that other programs open."""

from __future__ import annotations

import time
from pathlib import Path

from companion.cli.terminal import busy, say
from companion.cli.writing import writable, write
from companion.config.syntax.faults import ConfigError, Fault
from companion.library.faults import Faults


def export_flight(
    directory: Path, to: Path | None, *, csv: bool, mcap: bool, force: bool, ulog: Path | None = None
) -> None:
    """Write the files that were asked for. ConfigError: with every reason why they cannot be."""
    from companion.record.export.csv_files import csv_files
    from companion.record.export.folder import read_context
    from companion.record.export.mcap_file import write_mcap
    from companion.record.recorded import read_folder
    from companion.record.ulog.joined import joined, kept

    folder = directory if to is None else to
    faults = Faults()
    if not csv and not mcap and ulog is None:
        faults.add(Fault("--csv", 0, "", "missing; expected --csv, --mcap or --ulog-join FILE.ulg, or several"))
    flight = faults.collect(lambda: read_folder(directory))
    packed = folder / "flight.mcap"
    if mcap:
        faults.collect(lambda: writable("--mcap", packed, force))
    log = None
    if flight is not None:
        log = kept(directory) if ulog is None else faults.collect(lambda: joined(ulog, flight.table))
    names: tuple[str, ...] = ("flight.csv", "path.csv", "truth.csv", "columns.csv") if csv else ()
    if csv and log is not None:
        names += tuple(f"px4_{topic}.csv" for topic in log.topics)
    for name in names:
        faults.collect(lambda name=name: writable("--csv", folder / name, force))  # type: ignore[misc]
    faults.raise_any()
    assert flight is not None
    for cut in flight.cuts:
        say(f"note: {cut}")
    if ulog is not None and log is not None:
        from companion.cli.page import write_page
        from companion.cli.vehicle_log import keep_log

        keep_log(directory, log)
        write_page(directory)
    begun = time.monotonic()
    if mcap:
        with busy("writing flight.mcap"):
            try:
                messages = write_mcap(packed, flight, read_context(directory), log)
            except OSError as error:
                raise ConfigError([Fault(str(packed), 0, "", f"cannot be written: {error.strerror}")]) from None
        say(f"{packed}: {messages} messages, {time.monotonic() - begun:.1f} s")
    if csv:
        with busy("writing flight.csv"):
            for name, text in csv_files(flight, log).items():
                write(folder / name, text)
                rows = text.count(b"\n") - 1
                say(f"{folder / name}: {rows} rows")
