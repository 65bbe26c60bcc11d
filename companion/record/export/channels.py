"""A flight as series over time: what a person plots, in units that people read.

Every number is the recorded one; only angles are brought to degrees. What stands in the path's own words (arc length,
errors) is there from the first tick of following. Of a faster flight as many ticks are kept as a plot shows; flight.npy
and the CSV have all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.record.export.columns import Array
from companion.record.export.schemas import Field
from companion.record.series import Array as Numbers
from companion.record.series import roll_pitch
from companion.record.table import Table

_THRUST = Field("thrust", "1", "0..1")
SETPOINTS = {
    1: ("motors", [Field(f"motor_{i}", "1", f"command of rotor {i}, the vehicle file's units") for i in range(4)]),
    2: ("rates", [*(Field(f"{axis}_dps", "deg/s", f"body rate {axis} asked for") for axis in "pqr"), _THRUST]),
    4: ("torques", [*(Field(f"torque_{axis}", "1", f"torque about {axis}, a share") for axis in "xyz"), _THRUST]),
    3: ("attitude", [*(Field(f"q_{axis}", "1", "attitude, body to world, NED") for axis in "wxyz"), _THRUST]),
}
"""Columns ``sent_0`` .. ``sent_4`` of each value of the column ``setpoint``."""


RATE, SLOW_RATE = 100.0, 10.0
"""Hz at most: of states, errors and setpoints; of estimates and the link (engineering choice: 5 minutes in 5 s)."""


@dataclass(frozen=True)
class Series:
    """``topic``, ``schema``: its name; ``fields`` with one array of ``values`` each; ``t``: s, our clock."""

    topic: str
    schema: str
    fields: tuple[Field, ...]
    values: tuple[NDArray[np.float64], ...]
    t: Array


class Channel(NamedTuple):
    """``topic``, ``schema`` by name and text, and its messages: times in ns, JSON."""

    topic: str
    schema: str
    text: bytes
    times: NDArray[np.int64]
    data: Sequence[bytes]


def series_of(table: Table) -> list[Series]:
    """Everything of the table that a person plots."""
    steered = _at_most(table[np.isfinite(table["alpha"])], RATE)
    found = [
        _state(_at_most(table[table["fresh"] == 1], RATE)),
        _follow(steered),
        *_setpoints(table),
        _estimates(_at_most(steered, SLOW_RATE)),
        _link(_at_most(table, SLOW_RATE)),
    ]
    return [series for series in found if len(series.t)]


def thinned(t: Array, rate: float) -> NDArray[np.intp]:
    """Indices of rising times, ``rate`` a second at most: the first of each period."""
    slots = np.floor((t - t[:1]) * rate + 1e-6)
    return np.flatnonzero(np.diff(slots, prepend=-1.0) != 0)


def _at_most(rows: Table, rate: float) -> Table:
    return rows[thinned(rows["now"], rate)]


def euler_deg(q: Array) -> tuple[Array, Array, Array]:
    """Roll, pitch and heading in degrees of quaternions (n, 4) wxyz, body FRD to world NED."""
    w, x, y, z = q.T
    roll, pitch = roll_pitch(w, x, y, z)
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.degrees(roll), np.degrees(pitch), np.degrees(yaw)


def _series(topic: str, schema: str, rows: Table, columns: list[tuple[Field, Numbers]]) -> Series:
    fields, values = zip(*columns, strict=True)
    return Series(topic, f"companion.{schema}", fields, values, rows["now"])


def _state(rows: Table) -> Series:
    q = np.column_stack([rows[f"q_{axis}"] for axis in "wxyz"]).astype(float)
    roll, pitch, yaw = euler_deg(q)
    places = [
        (Field(f"{name}_m", "m", f"position {name}, local frame NED"), rows[name]) for name in ("north", "east", "down")
    ]
    speeds = [
        (Field(f"{name}_mps", "m/s", f"velocity {name[2:]}"), rows[name]) for name in ("v_north", "v_east", "v_down")
    ]
    angles = [
        (Field(f"{name}_deg", "deg", meaning), values)
        for name, values, meaning in (
            ("roll", roll, "body FRD"), ("pitch", pitch, "body FRD"), ("yaw", yaw, "heading, clockwise from north"),
            ("tilt", np.degrees(rows["tilt"]), "lean of the thrust axis"),
        )
    ]  # fmt: skip
    rates = [(Field(f"{axis}_dps", "deg/s", f"body rate {axis}"), np.degrees(rows[axis])) for axis in "pqr"]
    clock = [(Field("t_boot_s", "s", "the vehicle's clock"), rows["t_boot"])]
    return _series("/vehicle/state", "VehicleState", rows, places + speeds + angles + rates + clock)


def _follow(rows: Table) -> Series:
    speed = rows["speed"] * np.where(rows["ramp"] < 0.0, -1.0, 1.0)
    return _series("/follow", "Follow", rows, [
        (Field("path_error_m", "m", "distance to the path"), rows["path_error"]),
        (Field("speed_error_mps", "m/s", "speed along the path less the mission's"), speed - rows["alpha"]),
        (Field("yaw_error_deg", "deg", "heading less the mission's"), np.degrees(rows["yaw_error"])),
        (Field("s_m", "m", "arc length of the nearest point"), rows["s"]),
        (Field("travelled_m", "m", "along the path since following began"), rows["travelled"]),
        (Field("speed_mps", "m/s", "along the path"), rows["speed"]),
        (Field("speed_asked_mps", "m/s", "the mission's speed here"), rows["alpha"]),
        (Field("yaw_deg", "deg", "heading"), np.degrees(rows["yaw"])),
        (Field("yaw_asked_deg", "deg", "the mission's heading here"), np.degrees(rows["beta"])),
        (Field("thrust_n", "N", "collective thrust sent"), rows["thrust"]),
        (Field("saturated", "1", "1: a limit was met"), rows["saturated"]),
        (Field("speed_share", "1", "of the mission's speed that was asked for"), rows["pace"]),
        (Field("ramp", "1", "start and braking factor on the speed"), rows["ramp"]),
    ])  # fmt: skip


def _setpoints(table: Table) -> list[Series]:
    found = []
    for kind, (name, fields) in SETPOINTS.items():
        rows = _at_most(table[table["setpoint"] == kind], RATE)
        values = [
            np.degrees(rows[f"sent_{i}"]) if field.unit == "deg/s" else rows[f"sent_{i}"]
            for i, field in enumerate(fields)
        ]
        columns = list(zip(fields, values, strict=True))
        found.append(_series(f"/setpoint/{name}", f"Setpoint.{name}", rows, columns))
    return found


def _estimates(rows: Table) -> Series:
    return _series("/estimates", "Estimates", rows, [
        (Field("thrust_scale", "1", "acceleration made over asked for"), rows["thrust_scale"]),
        (Field("drag_per_s", "1/s", "linear drag over mass"), rows["drag"]),
        *((Field(f"disturbance_{axis}_mps2", "m/s^2", "disturbance found"), rows[f"push_{axis}"])
          for axis in ("north", "east", "down")),
        (Field("delay_s", "s", "from a state to its command's effect"), rows["delay"]),
        (Field("rate_loop_lag_s", "s", "of the rate loop"), rows["rate_lag"]),
        (Field("yaw_loop_lag_s", "s", "of the yaw rate loop"), rows["yaw_lag"]),
        (Field("motor_lag_s", "s", "of the motors"), rows["motor_lag"]),
        (Field("thrust_curve", "1", "slope of the thrust beyond proportion to its command"), rows["thrust_curve"]),
        (Field("thrust_curve_std", "1", "of it"), rows["thrust_curve_std"]),
        (Field("path_pole_per_s", "1/s", "of the distance to the path, where chosen"), rows["path_pole"]),
    ])  # fmt: skip


def _link(table: Table) -> Series:
    return _series("/link", "Link", table, [
        (Field("battery", "1", "what remains, 0..1"), table["battery"]),
        (Field("round_trip_s", "s", "of a message"), table["link_delay"]),
        (Field("state_rate_hz", "Hz", "of states"), table["rate"]),
        (Field("late_s", "s", "by which the state is older than the youngest"), table["late"]),
        (Field("latency_s", "s", "from the state's arrival to the return of the setpoint's send"), table["latency"]),
        (Field("phase", "1", "index of the phase, see the metadata"), table["phase"]),
    ])  # fmt: skip
