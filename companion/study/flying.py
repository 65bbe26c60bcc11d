"""One flight of a study -> one row of its results. Runs in a worker: values in, values out."""

from __future__ import annotations

import gc
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.calculus import machine_code
from companion.config.study.keys import RequireModel
from companion.library.calls import Asked, summary_of
from companion.library.comparing import figures_of
from companion.library.files import InputFile, MissionFile, VehicleFile, WorldFile
from companion.library.outcome import OwnFailureError
from companion.study.reading import Study, unmet
from companion.study.sampling import samples
from companion.study.stored import at_hand
from companion.study.variation import KINDS, inner_keys
from companion.vehicle import CompanionError
from companion.version import __version__


@dataclass(frozen=True)
class Case:
    """One flight of a study, with its files. ``varied``: its values by their keys."""

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
    completed: bool
    from_ground: bool


def cases_of(study: Study) -> list[Case]:
    """Every flight of a study."""
    model = study.model
    made = samples(model.vary, study.flights, model.sampling, model.seed)
    return [
        Case(
            index,
            *_files_of(study, varied),
            model.output,
            model.duration,
            model.settle,
            model.seed + index,
            varied,
            model.require,
            model.completed,
            model.from_ground,
        )
        for index, varied in enumerate(made)
    ]


def _files_of(study: Study, varied: dict[str, Any]) -> tuple[MissionFile, VehicleFile, WorldFile]:
    """The study's own files, or those that a flight chooses."""
    usual = {"mission": study.mission, "vehicle": study.vehicle, "world": study.world}
    files = (study.chosen[kind, str(varied[kind])] if kind in varied else usual[kind] for kind in KINDS)
    mission, vehicle, world = files
    assert isinstance(mission, MissionFile) and isinstance(vehicle, VehicleFile) and isinstance(world, WorldFile)
    return mission, vehicle, world


def asked_of(case: Case, mission: MissionFile, record: Path | None = None) -> Asked:
    """The flight as the library is asked for it. ``mission``: the case's, at hand. ConfigError: its values make no
    files."""
    usual: dict[str, InputFile] = {"mission": mission, "vehicle": case.vehicle, "world": case.world}
    changes = {kind: inner_keys(case.varied, kind) for kind in KINDS}
    options: dict[str, Any] = {
        "output": case.output, "duration": case.duration, "settle": case.settle, "seed": case.seed,
        **inner_keys(case.varied, "flight"),
    }  # fmt: skip
    flown, vehicle, world = (usual[kind].changed(changes[kind]) if changes[kind] else usual[kind] for kind in KINDS)
    assert isinstance(flown, MissionFile) and isinstance(vehicle, VehicleFile) and isinstance(world, WorldFile)
    return Asked(
        flown, vehicle, world, str(options["output"]), options["duration"], int(options["seed"]), None,
        float(options["settle"]), case.from_ground, None, record, lean=True,
    )  # fmt: skip


def row_of(case: Case, record: Path | None = None) -> dict[str, Any]:
    """The flight as one row: its values, how it ended, every number of its summary. ``record``: its folder, where one
    is wanted. Never raises."""
    begun = time.monotonic()
    machine_code.use()
    row: dict[str, Any] = {"index": case.index, "seed": case.varied.get("flight.seed", case.seed)}
    row |= {f"vary.{name}": value for name, value in case.varied.items()}
    figures: dict[str, Any] = {}
    failed: list[str] = []
    gc.disable()  # no tick leaves behind what only the collector finds: that comes when the flight is over
    try:
        with at_hand(case.mission) as mission:
            summary = summary_of(asked_of(case, mission, record))
        row |= {"outcome": summary["outcome"], "reason": summary["reason"]}
        figures = dict(figures_of(summary, ("follow", "settled", "truth", "loop", "found")))
        failed = unmet(case.require, figures)
    except OwnFailureError as error:
        row |= {"outcome": "failed", "reason": str(error)}
    except CompanionError as error:
        row |= {"outcome": "not flown", "reason": str(error).replace("\n", "; ")}
    except Exception as error:  # a flight that breaks the software is a result, and the others go on
        row |= {"outcome": "failed", "reason": f"{type(error).__name__}: {error}"}
    finally:
        gc.enable()
    row["passed"] = row["outcome"] in (("completed",) if case.completed else ("completed", "aborted")) and not failed
    row["unmet"] = "; ".join(failed)
    return {**row, **figures, "version": __version__, "wall_s": time.monotonic() - begun}
