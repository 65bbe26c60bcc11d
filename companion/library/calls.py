"""What the public functions do, once they are called: ``public`` has their signatures and imports nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from companion.config.syntax.faults import ConfigError, Fault
from companion.daemon.conductor import Conductor
from companion.daemon.last_resort import LastResort
from companion.feasibility.auto import flyable
from companion.feasibility.document import as_document
from companion.feasibility.report import Report
from companion.feasibility.words import headline, in_words
from companion.geodesy import NO_HOME_GIVEN
from companion.law.gains import Level
from companion.library.checking import STILL, checked, in_world
from companion.library.faults import Faults
from companion.library.files import InputFile, MissionFile, VehicleFile, WorldFile
from companion.library.flights import Flight
from companion.library.laws import ControlLaw
from companion.library.orders import (
    bare_from,
    given_home,
    simulated_from,
    sortie_from,
    source_of,
    vehicle_source,
)
from companion.library.outcome import Ended, OwnFailureError, figures_of, is_completed, reason_of
from companion.library.output import Output
from companion.library.simulation import Flown, SimulatedFlight, in_lockstep, in_memory
from companion.mission import Origin
from companion.places.words import words_of_place
from companion.record.circumstances import simulation_document
from companion.record.folder import Recorder, Source
from companion.record.place import refuse_used
from companion.record.summary import summary
from companion.vehicle import CompanionError

Given = str | Path


@dataclass(frozen=True)
class Check:
    """What ``check`` says: ``feasible``, the figures as the JSON ``document`` (``companion.check/1``), and all of it as
    ``words``, which is what it prints. ``report``: everything behind it."""

    report: Report
    document: dict[str, Any]
    words: str

    @property
    def feasible(self) -> bool:
        """Whether the vehicle can fly it as asked."""
        return self.report.feasible

    @property
    def headline(self) -> str:
        """The verdict in a sentence."""
        return headline(self.report)

    @property
    def speed_scale_max(self) -> float:
        """The largest factor on the whole speed that keeps every limit."""
        return self.report.speed_scale_max

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True)
class Asked:
    """A flight as it is asked for in Python. ``lean``: see SimulatedFlight."""

    mission: Given | MissionFile
    vehicle: Given | VehicleFile | None
    world: Given | WorldFile
    output: str
    duration: float | None
    seed: int
    gains: Mapping[str, Any] | None
    settle: float
    from_ground: bool
    home: str | None
    record: Path | None
    lean: bool = False


def simulate(asked: Asked) -> Flight:
    """See ``public.simulate``."""
    return _recorded(asked)[0]


def summary_of(asked: Asked) -> dict[str, Any]:
    """The summary of a flight, the same whether it leaves a folder behind or, where none is asked for, nothing.
    OwnFailureError: the companion itself failed. CompanionError: it did not begin."""
    if asked.record is not None:
        recorded, failure = _recorded(asked)
        if failure is not None:
            raise OwnFailureError(failure.sentence)
        return recorded.summary
    flight = _flight_of(asked)
    flown, ticks, truth = in_memory(flight)
    if flown.failure is not None:
        raise OwnFailureError(flown.failure.sentence)
    conductor, ended = flown.conductor, Ended(flown.now, False)
    reason = None if is_completed(conductor, ended) else reason_of(conductor, ended)
    if conductor.plan is None or conductor.memory is None:
        raise CompanionError(f"not flown: {reason}")
    outcome, simulation = "completed" if reason is None else "aborted", simulation_document(flight.simulated)
    return summary(conductor.plan, ticks.table, truth, asked.settle, outcome, reason, None, simulation)


def _recorded(asked: Asked) -> tuple[Flight, LastResort | None]:
    """The flight with its folder; what ended it where the companion itself failed."""
    flight = _flight_of(asked)
    sortie, temporary = flight.sortie, None if asked.record is not None else TemporaryDirectory(prefix="companion-")
    folder = asked.record if temporary is None else Path(temporary.name)
    assert folder is not None
    recorder = Recorder(folder, sortie.mission_source, sortie.vehicle_source, 0.0, flight.simulated)
    try:
        flown = in_lockstep(flight, recorder, lambda conductor: lambda now: _keep_notes(conductor, recorder, now))
    except BaseException:
        recorder.discard()
        raise
    _finish(flown, recorder, asked.settle)
    return Flight(folder, temporary), flown.failure


def _keep_notes(conductor: Conductor, recorder: Recorder, now: float) -> None:
    for note in conductor.notes:
        recorder.note(now, note)
    conductor.notes.clear()


def _flight_of(asked: Asked) -> SimulatedFlight:
    """What is asked for, read. ConfigError with every fault."""
    faults = Faults()
    output = faults.collect(lambda: _output(asked.output))
    world = faults.collect(lambda: _source(asked.world, WorldFile))
    simulated = None if world is None else faults.collect(lambda: simulated_from(world, asked.seed, asked.home))
    given = NO_HOME_GIVEN if simulated is None else faults.collect(lambda: given_home(asked.home, simulated.world))
    mission = faults.collect(lambda: _with_gains(asked.mission, asked.gains))
    vehicle = faults.collect(lambda: _vehicle(asked.vehicle, mission))
    if asked.duration is not None and not asked.duration >= 0.1:
        faults.add(Fault("duration", 0, "", f"{asked.duration:g} is too short; expected at least 0.1 s"))
    if asked.record is not None:
        faults.collect(lambda: refuse_used(asked.record))  # type: ignore[arg-type]
    sortie = sortie_from(
        mission, vehicle, output or Output.AUTO, direct=True, given=given or NO_HOME_GIVEN, faults=faults
    )
    assert simulated is not None
    try:
        sortie = replace(sortie, mission=flyable(sortie.mission, sortie.vehicle))
    except (ValueError, ArithmeticError) as error:
        raise ConfigError([Fault(sortie.mission_source.name, 0, "path", str(error))]) from None
    return SimulatedFlight(sortie, simulated, asked.from_ground, asked.duration, lean=asked.lean)


def _finish(flown: Flown, recorder: Recorder, settle: float) -> None:
    """Close the record. CompanionError: the flight did not begin."""
    conductor, ended = flown.conductor, Ended(flown.now, False, flown.failure)
    recorder.flush(sync=True)
    if flown.failure is not None:
        recorder.keep_failure(flown.failure.trace)
    reason = None if is_completed(conductor, ended) else reason_of(conductor, ended)
    if conductor.plan is None or conductor.memory is None:
        recorder.discard()
        if flown.failure is not None:
            raise OwnFailureError(flown.failure.sentence)
        raise CompanionError(f"not flown: {reason}")
    figures_of(conductor, recorder, settle, reason)
    recorder.close()


def check(
    mission: Given | MissionFile, vehicle: Given | VehicleFile | None, output: str, world: Given | WorldFile | None,
    home: str | None,
) -> Check:  # fmt: skip
    """See ``public.check``."""
    faults = Faults()
    level = faults.collect(lambda: _output(output))
    simulated = None
    if world is not None:
        simulated = faults.collect(lambda: simulated_from(_source(world, WorldFile), 0))
    given = faults.collect(lambda: given_home(home, None if simulated is None else simulated.world))
    read = faults.collect(lambda: _source(mission, MissionFile))
    machine = faults.collect(lambda: _vehicle(vehicle, read))
    sortie = sortie_from(read, machine, level or Output.AUTO, direct=True, given=given or NO_HOME_GIVEN, faults=faults)
    sortie, air = in_world(sortie, None if simulated is None else simulated.world)
    sortie, found = checked(sortie, STILL if air is None else air.wind_n)
    places = words_of_place(sortie.mission, Origin.TAKEOFF)
    words = in_words(found, places.lines, places.warnings, None if air is None else air.words)
    return Check(found, as_document(found, places.lines, places.warnings), words)


def control_law(mission: Given | MissionFile, vehicle: Given | VehicleFile | None, level: str) -> ControlLaw:
    """See ``public.control_law``."""
    if level not in ("motors", "rates"):
        raise ConfigError([Fault("level", 0, "", f"{level!r} is not known; expected motors or rates")])
    known = Level.MOTORS if level == "motors" else Level.RATES
    faults = Faults()
    read = faults.collect(lambda: _source(mission, MissionFile))
    machine = faults.collect(lambda: _vehicle(vehicle, read))
    return ControlLaw(*bare_from(read, machine, known, faults), known)


def _source(given: Given | InputFile, kind: type[InputFile]) -> Source:
    if isinstance(given, str | Path):
        return source_of(str(given), kind.folder)
    if not isinstance(given, kind):
        message = f"a {type(given).__name__}; expected a name, a path or a {kind.__name__}"
        raise ConfigError([Fault(kind.folder.removesuffix("s"), 0, "", message)])
    return given.source


def _vehicle(given: Given | VehicleFile | None, mission: Source | None) -> Source:
    """The vehicle that is asked for, else the mission's own, else x500."""
    return vehicle_source(None, mission) if given is None else _source(given, VehicleFile)


def _with_gains(given: Given | MissionFile, gains: Mapping[str, Any] | None) -> Source:
    if gains is None:
        return _source(given, MissionFile)
    file = given if isinstance(given, MissionFile) else MissionFile.load(given)
    return file.changed({"gains": gains}).source


def _output(name: str) -> Output:
    known = [each.value for each in Output]
    if name not in known:
        raise ConfigError([Fault("output", 0, "", f"{name!r} is not known; expected {', '.join(known)}")])
    return Output(name)
