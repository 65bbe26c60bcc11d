"""A study file -> a study, or every fault at once, each with its line."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.config.study.keys import RequireModel, StudyModel
from companion.config.syntax.document import Document, parse
from companion.config.syntax.faults import ConfigError, Fault
from companion.config.syntax.file_lookup import read
from companion.config.syntax.schema import validate
from companion.library.files import InputFile, MissionFile, VehicleFile, WorldFile
from companion.library.orders import vehicle_source
from companion.study.sampling import drawn_names, grid_size, saltelli_block, whole_power
from companion.study.variation import KINDS, Chosen, check_variation, file_of

FLIGHTS = 100
"""Flights of a study that draws and does not say how many (engineering choice)."""
_SIZES = ("path_error_m", "speed_error_mps", "yaw_error_deg")
_FLOWN = ("duration_s", "distance_m", "laps", "speed_mean_over_alpha")
_SETTLED = ("roll_max_deg", "pitch_max_deg", "tilt_max_deg", "thrust_n.min", "thrust_n.max", "motor.saturated_fraction")
_FLIGHT = ("height_min_m", "height_max_m", "speed_max_mps", "tilt_max_deg", "impact_mps")
FIGURES = (
    *(
        f"{part}.{name}"
        for part in ("follow", "settled", "truth.follow", "truth.settled")
        for name in (*_FLOWN, *(f"{size}.{which}" for size in _SIZES for which in ("rms", "max")))
    ),
    *(f"{part}.{name}" for part in ("settled", "truth.settled") for name in _SETTLED),
    *(f"truth.flight.{name}" for name in _FLIGHT),
    *("loop.rate_hz", "loop.gap_max_ms"),
)
"""What may be required of."""


@dataclass(frozen=True)
class Study:
    """``mission``, ``vehicle``, ``world``: the files that every flight begins from. ``chosen``: those that a choice
    puts in their places, by kind and name. ``text``: of the study's file."""

    model: StudyModel
    mission: MissionFile
    vehicle: VehicleFile
    world: WorldFile
    chosen: Chosen
    text: str

    @property
    def name(self) -> str:
        """As its file says."""
        return self.model.study

    @property
    def flights(self) -> int:
        """How many."""
        given, grid, drawn = self.model.flights, grid_size(self.model.vary), len(drawn_names(self.model.vary))
        if given is not None or not drawn:
            return given or grid
        if self.model.sampling != "saltelli":
            return FLIGHTS
        block = grid * saltelli_block(drawn)
        return block * whole_power(FLIGHTS / block)


def load_study(file: Path) -> Study:
    """The study in a file. ConfigError with every fault."""
    if not file.is_file():
        raise ConfigError([Fault(str(file), 0, "", "no such file; expected a study file")])
    return study_from(read(file), str(file))


def study_from(text: str, name: str) -> Study:
    """The study a text describes; ``name``: of its file, which other files lie beside. ConfigError with every fault."""
    document = parse(text, name)
    faults: list[Fault] = []
    model = None
    try:
        model = validate(document, StudyModel)
    except ConfigError as error:
        faults += error.faults
        if not isinstance(document.data, dict):
            raise
    files = _files(document, faults)
    chosen = check_variation(document, files, faults)
    _check_requirements(document, faults)
    if model is not None:
        _check_design(document, model, faults)
    if faults or model is None:
        raise ConfigError(faults)
    return study_of(model, files, chosen, text)


def study_of(model: StudyModel, files: dict[str, InputFile], chosen: Chosen, text: str) -> Study:
    """A study of files that are at hand."""
    mission, vehicle, world = (files[kind] for kind in KINDS)
    assert isinstance(mission, MissionFile) and isinstance(vehicle, VehicleFile) and isinstance(world, WorldFile)
    return Study(model, mission, vehicle, world, chosen, text)


def _files(document: Document, faults: list[Fault]) -> dict[str, InputFile]:
    """The files that can be read; what is wrong with the others is added."""
    files: dict[str, InputFile] = {}
    data, beside = document.data, Path(document.file).parent
    for kind in KINDS:
        name = data.get(kind, "ideal" if kind == "world" else None)
        try:
            if isinstance(name, str):
                files[kind] = file_of(kind, name, beside)
            elif name is None and kind == "vehicle" and "mission" in files:
                files[kind] = VehicleFile(vehicle_source(None, files["mission"].source)).checked()
        except ConfigError as error:
            at = (kind,)
            # the file that is named is at fault: its own lines, and where it is not there, the study's line
            own = [fault for fault in error.faults if fault.line]
            faults += own or [document.fault(at, fault.message) for fault in error.faults]
    return files


def _check_requirements(document: Document, faults: list[Fault]) -> None:
    required = document.data.get("require")
    for key in required if isinstance(required, dict) else ():
        if key not in FIGURES:
            close = difflib.get_close_matches(key, FIGURES, 1)
            hint = f"did you mean {close[0]}?" if close else "expected a figure such as truth.settled.path_error_m.rms"
            faults.append(document.fault(("require", key), f"is no figure of a flight; {hint}"))


def _check_design(document: Document, model: StudyModel, faults: list[Fault]) -> None:
    """Saltelli's design has whole blocks, and a power of two of them."""
    if model.sampling != "saltelli":
        return
    drawn = len(drawn_names(model.vary))
    if not drawn:
        faults.append(document.fault(("sampling",), "draws nothing; expected a key of vary that is no choice or range"))
        return
    block = grid_size(model.vary) * saltelli_block(drawn)
    if model.flights is not None and model.flights != (more := block * whole_power(model.flights / block)):
        less = f"{more // 2} or " if more > block else ""
        message = f"{model.flights} flights are no whole design of {drawn} draws; expected {less}{more}"
        faults.append(document.fault(("flights",), message))


def unmet(required: dict[str, RequireModel], row: dict[str, Any]) -> list[str]:
    """The figures of a completed flight that are not as required, in words."""
    said = []
    for name, bounds in required.items():
        value = row.get(name)
        if value is None:
            said.append(f"{name} is not known")
        elif bounds.max is not None and value > bounds.max:
            said.append(f"{name} is {value:.4g}, required at most {bounds.max:g}")
        elif bounds.min is not None and value < bounds.min:
            said.append(f"{name} is {value:.4g}, required at least {bounds.min:g}")
    return said
