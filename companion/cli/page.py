"""The page of a flight, written when the flight is over: never the business of its exit code."""

from __future__ import annotations

from pathlib import Path

from companion.cli.terminal import busy, say
from companion.daemon.last_resort import error_words
from companion.vehicle import CompanionError


def write_page(directory: Path) -> None:
    """Write ``report.html`` and say where; where it cannot be, say how it can be made."""
    try:
        from companion.record.report import write_report

        with busy("drawing the report"):
            page = write_report(directory)
        say(f"report: {page}")
    except CompanionError as error:
        say(f"no report: {error}; then: companion report {directory}")
    except KeyboardInterrupt:  # the flight is over: only the page is stopped
        say(f"no report: stopped; companion report {directory} makes it")
    except Exception as error:  # the flight is flown and recorded: a page that fails must not make it a failure
        say(f"no report: {error_words(error)}; once that is mended: companion report {directory}")
