"""What ``import companion`` offers. Nothing heavy is imported until a function is called (a test holds it).

A mission, a vehicle or a world may be given by its name in configs/, as the path of a file, or as what ``load_*`` and
``new_*`` return. What is wrong is raised as ``CompanionError``, in the sentences of the commands.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from companion.library.calls import Check
    from companion.library.comparing import Comparison
    from companion.library.files import MissionFile, VehicleFile, WorldFile
    from companion.library.flights import Flight
    from companion.library.laws import ControlLaw


def load_mission(name: str | Path) -> MissionFile:
    """The mission of a name in configs/missions, of a mission file or of a plan. ConfigError with every fault."""
    from companion.library.files import MissionFile

    return MissionFile.load(name)


def load_vehicle(name: str | Path) -> VehicleFile:
    """The vehicle of a name in configs/vehicles or of a file. ConfigError with every fault."""
    from companion.library.files import VehicleFile

    return VehicleFile.load(name)


def load_world(name: str | Path) -> WorldFile:
    """The world of a name in configs/worlds or of a file. ConfigError with every fault."""
    from companion.library.files import WorldFile

    return WorldFile.load(name)


def new_mission(
    name: str, path: Mapping[str, Any], speed: Any, yaw: Any = 0.0, *, frame: str = "ned", **keys: Any
) -> MissionFile:
    """A mission. ``path``: from ``implicit_path``, ``curve_path``, ``path_through``, or a mapping as a file has it
    (``{"kind": "circle", "center": [0, 0, -10], "radius": 5}``). ``speed`` (m/s), ``yaw`` (degrees): as in a file, or a
    function of x, y, z on an implicit path, of s on a curve. ``keys``: any other key of a mission file."""
    from companion.library.making import new_mission as make

    return make(name, path, speed, yaw, frame, keys)


def new_vehicle(name: str, **keys: Any) -> VehicleFile:
    """A vehicle from the keys of a vehicle file: mass_kg, inertia_kgm2, rotors, ..."""
    from companion.library.making import new_vehicle as make

    return make(name, keys)


def new_world(name: str, **keys: Any) -> WorldFile:
    """A world from the keys of a world file: wind_mps, gusts, link, truth, ..."""
    from companion.library.making import new_world as make

    return make(name, keys)


def implicit_path(
    h1: str | Callable[..., Any], h2: str | Callable[..., Any], near: Sequence[float] | None = None, **constants: float
) -> dict[str, Any]:
    """The path h1 = h2 = 0 in x, y, z (m): expressions, or functions of x, y, z. ``near``: a point near the part that
    is meant."""
    from companion.library.making import implicit_path as make

    return make(h1, h2, near, constants)


def curve_path(position: Callable[..., Any], u: Sequence[float], *, closed: bool = False) -> dict[str, Any]:
    """The path ``position(u) -> (x, y, z)`` (m) for u from u[0] to u[1], a function in numpy's functions."""
    from companion.library.making import curve_path as make

    return make(position, u, closed)


def path_through(
    points: Sequence[Sequence[float]], *, closed: bool = False, corner_tolerance: float | None = None
) -> dict[str, Any]:
    """The smooth path through points [x, y, z] (m); with ``corner_tolerance`` (m) straight legs whose corners are
    rounded within it."""
    from companion.library.making import path_through as make

    return make(points, closed, corner_tolerance)


def check(
    mission: str | Path | MissionFile, vehicle: str | Path | VehicleFile | None = None, *, output: str = "auto",
    world: str | Path | WorldFile | None = None, home: str | None = None,
) -> Check:  # fmt: skip
    """Whether a vehicle can fly a mission, how fast at most, where it is tight; as ``companion check``."""
    from companion.library.calls import check as look

    return look(mission, vehicle, output, world, home)


def simulate(
    mission: str | Path | MissionFile, vehicle: str | Path | VehicleFile | None = None, *,
    world: str | Path | WorldFile = "ideal", output: str = "auto", duration: float | None = None, seed: int = 0,
    gains: Mapping[str, Any] | None = None, settle: float = 10.0, from_ground: bool = False, home: str | None = None,
    record: str | Path | None = None,
) -> Flight:  # fmt: skip
    """Fly a mission in simulation, as ``companion sim`` does. ``output``: auto, motors, rates, attitude. ``duration``:
    s of following. ``gains``: in the place of the mission's, e.g. ``{"poles": {"path": [-3, -3, -3]}}``. ``settle``: s
    after which the flight counts as settled. ``record``: the folder that keeps it, new or empty; None: a temporary one,
    which goes with the flight.

    A flight that was aborted is a result: ``flight.completed``, ``flight.summary["reason"]``. ConfigError: something is
    wrong with what was given. CompanionError: it did not begin."""
    from companion.library.calls import Asked
    from companion.library.calls import simulate as fly

    keep = None if record is None else Path(record)
    return fly(Asked(mission, vehicle, world, output, duration, seed, gains, settle, from_ground, home, keep))


def compare(a: Flight | str | Path, b: Flight | str | Path) -> Comparison:
    """Two flights, or their folders, side by side: every figure of both."""
    from companion.library.comparing import compared
    from companion.library.flights import Flight

    of_a, of_b = (each if isinstance(each, Flight) else Flight.load(each) for each in (a, b))
    return compared(of_a, of_b)


def control_law(
    mission: str | Path | MissionFile, vehicle: str | Path | VehicleFile | None = None, level: str = "motors"
) -> ControlLaw:
    """The paper's law at ``level`` (motors or rates), a function of the state: ``law(chi) -> (xi, b, D, u, tau)``. The
    path must be implicit. No limit, clamp, wrap or drag."""
    from companion.library.calls import control_law as make

    return make(mission, vehicle, level)
