"""``companion study``: one mission flown many times, each time a little different."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.terminal import say, tell

study = typer.Typer(no_args_is_help=True, help="One mission flown many times, each time a little different.")
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a study.")]


@study.command()
def run(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A study file.")],
    workers: Annotated[
        int, typer.Option(metavar="N", min=1, help="Workers on this machine.", show_default="one a core")
    ] = os.cpu_count() or 1,
    scheduler: Annotated[
        str | None, typer.Option(metavar="URL", help="Fly on the workers of this dask scheduler (tcp://HOST:8786).")
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record", metavar="DIR", help="The folder of the results.", show_default="studies/DATE-TIME-NAME"
        ),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where a run of this study was ended.")] = False,
) -> None:
    """Fly a study. Exit code: 0 it holds, 1 it does not, 2 the file is wrong, 130 it was interrupted."""
    from companion.cli.study_progress import Progress
    from companion.study.engine import flown
    from companion.study.flying import cases_of
    from companion.study.reading import load_study
    from companion.study.results import Results, last_study_directory, new_study_directory
    from companion.study.telling import in_words, judged

    read = load_study(file)
    directory = record or (last_study_directory(read.name) if resume else None) or new_study_directory(read.name)
    results = Results(directory, read, resume)
    cases = [case for case in cases_of(read) if case.index not in results.rows]
    say(f"{read.name}: {len(cases)} of {read.flights} flights to fly, results in {directory}")
    interrupted = False
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C: so a batch system ends a job
    with Progress(len(cases)) as progress:
        try:
            flown(cases, workers, scheduler, lambda row: progress.step(results.add(row)))
        except KeyboardInterrupt:
            interrupted = True
        finally:
            signal.signal(signal.SIGTERM, before)
            results.close()
    rows = [results.rows[index] for index in sorted(results.rows)]
    said = judged(read.model, rows, read.flights)
    for line in in_words(said):
        tell(line)
    tell(f"results: {directory}")
    raise typer.Exit(130 if interrupted else 0 if said.holds else 1)


@study.command()
def report(directory: Folder) -> None:
    """Tell a study's results again, write its tables and its page."""
    from companion.study.page import write_page
    from companion.study.results import load_rows, load_run_study, write_tables
    from companion.study.telling import in_words, judged

    rows, read = load_rows(directory), load_run_study(directory)
    write_tables(directory, rows)
    said = judged(read.model, rows, read.flights)
    for line in in_words(said):
        tell(line)
    tell(str(write_page(directory, read, rows, said)))


@study.command()
def replay(
    directory: Folder, index: Annotated[int, typer.Argument(metavar="INDEX", min=0, help="The number of the flight.")]
) -> None:
    """Fly one flight of a study again, with its folder and its page. Exit code: 0 the same figures, 1 others."""
    from companion.cli.page import write_page
    from companion.config.syntax.faults import ConfigError, Fault
    from companion.study.flying import cases_of, row_of
    from companion.study.results import load_rows, load_run_study
    from companion.study.telling import line_of

    rows = {row["index"]: row for row in load_rows(directory)}
    read = load_run_study(directory)
    if index not in rows:
        raise ConfigError(
            [Fault("INDEX", 0, "", f"{index} is not among the {len(rows)} flights; expected one of them")]
        )
    folder, number = directory / "flights" / str(index), 2
    while folder.exists():
        folder, number = folder.with_name(f"{index}-{number}"), number + 1
    again = row_of(cases_of(read)[index], folder)
    tell(line_of(read.model, again))
    changed = [key for key in again if key not in ("wall_s", "version") and again[key] != rows[index].get(key)]
    if folder.is_dir():
        write_page(folder)
        tell(f"flight folder: {folder}")
    tell(f"differs: {', '.join(changed)}" if changed else "the same figures, bit for bit")
    raise typer.Exit(1 if changed else 0)


@study.command()
def worst(directory: Folder) -> None:
    """The ten flights that went worst, by their numbers."""
    from companion.study.results import load_rows, load_run_study
    from companion.study.telling import line_of
    from companion.study.telling import worst as worst_of

    model = load_run_study(directory).model
    for row in worst_of(model, load_rows(directory)):
        tell(line_of(model, row))


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.add_typer(study, name="study")
