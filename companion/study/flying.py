"""One flight of a study -> one row of its results. Runs in a worker: values in, values out."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.config.study.keys import RequireModel
from companion.library.calls import Asked, simulate
from companion.library.comparing import figures_of
from companion.library.files import InputFile, MissionFile, VehicleFile, WorldFile
from companion.library.flights import Flight
from companion.record.circumstances import software_version
from companion.study.reading import KINDS, Study, file_of, unmet
from companion.study.sampling import samples
from companion.vehicle import CompanionError


@dataclass(frozen=True)
class Case:
    """One flight of a study. ``varied``: its values by their keys. ``beside``: where files that vary lie."""

    index: int
    mission: MissionFile
    vehicle: VehicleFile
    world: WorldFile
    output: str
    duration: float | None
    settle: float
    seed: int
    varied: dict[str, Any]
    require: dict[str, RequireModel]
    beside: str


def cases_of(study: Study, beside: Path) -> list[Case]:
    """Every flight of a study."""
    model = study.model
    made = samples(model.vary, study.flights, model.sampling, model.seed)
    return [
        Case(
            index,
            study.mission,
            study.vehicle,
            study.world,
            model.output,
            model.duration,
            model.settle,
            model.seed + index,
            varied,
            model.require,
            str(beside),
        )
        for index, varied in enumerate(made)
    ]


def fly(case: Case, record: Path | None = None) -> Flight:
    """Fly it. ConfigError: its values make no flight. CompanionError: it did not begin."""
    files: dict[str, InputFile] = {"mission": case.mission, "vehicle": case.vehicle, "world": case.world}
    changes: dict[str, dict[str, Any]] = {kind: {} for kind in KINDS}
    options: dict[str, Any] = {
        "output": case.output, "duration": case.duration, "settle": case.settle, "seed": case.seed,
    }  # fmt: skip
    for key, value in case.varied.items():
        kind, _, inner = key.partition(".")
        if kind == "flight":
            options[inner] = value
        elif inner:
            changes[kind][inner] = value
        else:
            files[kind] = file_of(kind, str(value), Path(case.beside))
    mission, vehicle, world = (files[kind].changed(changes[kind]) if changes[kind] else files[kind] for kind in KINDS)
    assert isinstance(mission, MissionFile) and isinstance(vehicle, VehicleFile) and isinstance(world, WorldFile)
    return simulate(
        Asked(mission, vehicle, world, str(options["output"]), options["duration"], int(options["seed"]), None,
              float(options["settle"]), False, None, record)
    )  # fmt: skip


def row_of(case: Case, record: Path | None = None) -> dict[str, Any]:
    """The flight as one row: its values, how it ended, every number of its summary. Never raises."""
    begun = time.monotonic()
    row: dict[str, Any] = {"index": case.index, "seed": case.varied.get("flight.seed", case.seed)}
    row |= {f"vary.{name}": value for name, value in case.varied.items()}
    figures: dict[str, Any] = {}
    try:
        summary = fly(case, record).summary
        row |= {"outcome": summary["outcome"], "reason": summary["reason"]}
        figures = dict(figures_of(summary, ("follow", "settled", "truth", "loop", "found")))
        failed = unmet(case.require, figures)
    except CompanionError as error:
        row |= {"outcome": "not flown", "reason": str(error).replace("\n", "; ")}
        failed = []
    except Exception as error:  # a flight that breaks the software is a result, and the others go on
        row |= {"outcome": "failed", "reason": f"{type(error).__name__}: {error}"}
        failed = []
    row["passed"] = row["outcome"] == "completed" and not failed
    row["unmet"] = "; ".join(failed)
    return {**row, **figures, "version": software_version(), "wall_s": time.monotonic() - begun}
