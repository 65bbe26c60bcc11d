"""The followed part of a flight as one array a quantity: as the companion saw it, and as it truly was."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from companion.flight.phases import Phase
from companion.frames import rotation_matrix, tilt, wrap
from companion.record.table import Table

if TYPE_CHECKING:  # an export needs no plan
    from companion.plan import Plan

Array = NDArray[np.float64]

PHASES = list(Phase)
FOLLOW = PHASES.index(Phase.FOLLOW)
TRUTH_RATE = 100.0
"""Hz at which the true state is measured against the path."""


def followed_series(table: Table) -> dict[str, Array]:
    """The followed part of a flight, one entry a steered tick. ``stretch``: a pilot may take over and give back.
    ``t``: s of following; ``since``: s since following began, or began again. ``speed``: on the way back counted as on
    the way out."""
    steered = (table["phase"] == FOLLOW) & np.isfinite(table["alpha"])
    rows = table[steered]
    columns = {name: np.asarray(rows[name], dtype=float) for name in rows.dtype.names or ()}
    columns["stretch"] = stretches(table)[steered]
    t_boot = columns["t_boot"]
    goes_on = np.diff(columns["stretch"]) == 0
    columns["t"] = np.cumsum(np.concatenate(([0.0], np.where(goes_on, np.diff(t_boot), 0.0))))[: len(rows)]
    begins = np.concatenate(([True], ~goes_on))[: len(rows)]
    columns["since"] = t_boot - t_boot[begins][np.cumsum(begins) - 1]
    columns["speed"] = columns["speed"] * np.where(columns["ramp"] < 0.0, -1.0, 1.0)
    columns["speed_error"] = columns["speed"] - columns["alpha"]
    columns["roll"], columns["pitch"] = roll_pitch(*(columns[f"q_{axis}"] for axis in "wxyz"))
    return columns


def is_rising(t: Array) -> NDArray[np.bool_]:
    """Which times, s, are later than all before them: what may be interpolated between."""
    return np.concatenate(([True], t[1:] > np.maximum.accumulate(t)[:-1]))


def roll_pitch(w: Array, x: Array, y: Array, z: Array) -> tuple[Array, Array]:
    """rad, of attitudes body FRD to world NED."""
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))


def stretches(table: Table) -> Array:
    """Which stretch of following each row is in, counted from 1; 0 where the path is not followed."""
    following = table["phase"] == FOLLOW
    begins = following & ~np.concatenate(([False], following[:-1]))
    return np.where(following, np.cumsum(begins), 0).astype(float)


def true_series(plan: Plan, estimated: dict[str, Array], truth: Table) -> dict[str, Array]:
    """The same from the plant's true state, while the companion was following."""
    t_boot = estimated["t_boot"]
    if len(t_boot) == 0 or len(truth) == 0:
        return _nothing()
    rows = truth[(truth["t_boot"] >= t_boot[0]) & (truth["t_boot"] <= t_boot[-1])]
    rows = rows[np.interp(rows["t_boot"], t_boot, estimated["stretch"]) % 1.0 == 0.0]
    if len(rows) > 1:
        stride = max(1, round(1.0 / TRUTH_RATE / float(np.median(np.diff(rows["t_boot"])))))
        rows = rows[::stride]
    names = ("stretch", "t", "since", "ramp", "speed_scale")
    then = (np.interp(rows["t_boot"], t_boot, estimated[name]).tolist() for name in names)
    true = (rows[name].tolist() for name in ("p_n", "v_n", "q_nb", "rotor_thrusts", "commands"))
    collected = []
    s: float | None = None
    travelled, flown = 0.0, 0.0
    for p_n, v_n, q_nb, thrusts, commands, stretch, t, since, ramp, scale in zip(*true, *then, strict=True):
        way = -1.0 if ramp < 0.0 else 1.0
        if s is None or stretch != flown:
            s, distance = plan.table.locate(p_n)
            flown = stretch
        else:
            before = s
            s, distance = plan.table.nearest(p_n, s, 1.0 + 0.2 * math.hypot(*v_n))
            travelled += way * plan.direction * plan.table.difference(s, before)
        _, mu, _ = plan.table.at(s)
        r_nb = rotation_matrix(q_nb)
        speed = way * (mu[0] * v_n[0] + mu[1] * v_n[1] + mu[2] * v_n[2])
        alpha = plan.mission.alpha(s)
        yaw = plan.mission.heading.of(r_nb)
        collected.append(
            (
                t,
                since,
                distance,
                speed,
                alpha,
                speed - alpha,
                wrap(yaw - plan.mission.beta(s)),
                travelled,
                ramp,
                scale,
                math.atan2(r_nb[7], r_nb[8]),
                math.asin(max(-1.0, min(1.0, -r_nb[6]))),
                tilt(r_nb),
                sum(thrusts),
                *commands,
            )
        )
    values = np.array(collected).reshape(len(collected), len(_TRUE_COLUMNS))
    return {name: values[:, i] for i, name in enumerate(_TRUE_COLUMNS)}


_TRUE_COLUMNS = (
    "t", "since", "path_error", "speed", "alpha", "speed_error", "yaw_error", "travelled", "ramp", "speed_scale",
    "roll", "pitch", "tilt", "thrust", "sent_0", "sent_1", "sent_2", "sent_3",
)  # fmt: skip


def _nothing() -> dict[str, Array]:
    return {name: np.zeros(0) for name in _TRUE_COLUMNS}
