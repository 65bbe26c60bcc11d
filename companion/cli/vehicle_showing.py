"""``vehicle show``: what a vehicle's file says beside what its last flight found, and what the next one begins with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from companion.cli.finish import COMPLETED
from companion.cli.terminal import tell
from companion.config.vehicle import load_vehicle
from companion.estimation.learned import AGEING, Learned, prior_of
from companion.record.learned import load_learned, state_file
from companion.vehicle import Vehicle


class Row(NamedTuple):
    """One figure: of the file, as learned with its standard deviation, and as believed at the start of a flight. None
    where there is none."""

    key: str
    unit: str
    told: float | None
    learned: float | None
    learned_std: float | None
    believed: float | None
    believed_std: float | None


def show(name: str, as_json: bool) -> int:
    """Print it; the exit code."""
    vehicle = load_vehicle(name)
    file = state_file(vehicle.name)
    learned = load_learned(file)
    rows = rows_of(vehicle, learned)
    if as_json:
        tell(json.dumps(_document(vehicle, learned, file, rows), indent=2))
        return COMPLETED
    tell(f"{vehicle.name}: {vehicle.mass:g} kg, thrust {vehicle.thrust_max / vehicle.weight:.2f} times its weight")
    tell(f"  {'':22}{'file':>10}{'learned':>20}{'next flight begins with':>28}")
    for row in rows:
        name_ = f"{row.key}{', ' + row.unit if row.unit else ''}"
        told = "-" if row.told is None else f"{row.told:.3g}"
        learned_, believed = _cell(row.learned, row.learned_std), _cell(row.believed, row.believed_std)
        tell(f"  {name_:22}{told:>10}{learned_:>20}{believed:>28}")
    if learned is None:
        tell(
            f"nothing is learned of it yet: a flight of 15 s writes {file}" if file else "nothing can be kept: no HOME"
        )
    else:
        tell(f"learned {learned.age_days:.1f} days ago ({file}); after {AGEING:g} days the file counts alone")
    return COMPLETED


def rows_of(vehicle: Vehicle, learned: Learned | None) -> list[Row]:
    """The figures that flights learn."""
    hover = vehicle.hover_thrust or vehicle.weight / vehicle.thrust_max
    prior = prior_of(learned, hover, vehicle.drag)
    scale, scale_std = prior.thrust_scale
    lag = vehicle.rate_loop_lag
    rows = [
        Row(
            "hover thrust", "", vehicle.hover_thrust, learned and learned.hover_thrust,
            learned and learned.hover_thrust_std, hover / scale, hover / scale * scale_std / scale,
        ),
        Row("drag", "1/s", vehicle.drag, learned and learned.drag, learned and learned.drag_std, *prior.drag),
        Row("rate loop lag", "s", lag, learned and learned.rate_lag, None, learned.rate_lag if learned else lag, None),
    ]  # fmt: skip
    if learned is not None:
        yaw_lag = learned.yaw_lag or None
        rows.append(Row("yaw loop lag", "s", None, yaw_lag, None, yaw_lag, None))
    return rows


def _cell(value: float | None, std: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.3g}" + (f" +- {std:.2g}" if std is not None else "")


def _document(vehicle: Vehicle, learned: Learned | None, file: Path | None, rows: list[Row]) -> dict[str, Any]:
    return {
        "schema": "companion.vehicle/1",
        "vehicle": vehicle.name,
        "state_file": None if file is None else str(file),
        "age_days": None if learned is None else round(learned.age_days, 3),
        "figures": [row._asdict() for row in rows],
    }
