"""What was fitted, drawn over what was seen: the rate loops and the specific force. Needs matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from companion.identification.from_log import AXES, Findings

ASKED, SEEN, MODEL, FAINT = "#9aa7b3", "#0072b2", "#d55e00", "#5d6b78"
SHOWN = 12.0
"""s of the longest part that are drawn."""


def picture(found: Findings) -> Figure:
    """Body rates asked for, seen and modelled, axis by axis; the specific force along z, seen and modelled."""
    figure = Figure(figsize=(11.0, 9.0), dpi=110, layout="constrained")
    figure.suptitle(f"{found.log.identity}: {found.flown:.0f} s in the air", x=0.012, ha="left", fontsize=12)
    rows = figure.subplots(4, 1, sharex=True)
    longest = max(range(len(found.parts)), key=lambda i: len(found.parts[i].t))
    part = found.parts[longest]
    begin = _liveliest(part.t, part.rates_setpoint)
    shown = (part.t >= begin) & (part.t < begin + SHOWN)
    t = part.t[shown]
    for i, (axes, name, axis) in enumerate(zip(rows, AXES, found.axes, strict=False)):
        for what, column, colour, width in (
            ("asked", part.rates_setpoint[:, i], ASKED, 1.0),
            ("gyro", part.gyro[:, i], SEEN, 0.9),
            *((("model", axis.model[longest], MODEL, 1.3),) if axis.model else ()),
        ):
            axes.plot(t, np.degrees(column[shown]), color=colour, linewidth=width, label=what)
        axes.set_ylabel(f"{name} rate, deg/s", color=FAINT, fontsize=9)
    force = found.forces
    within = (force.t >= begin) & (force.t < begin + SHOWN)
    rows[3].plot(force.t[within], -force.seen[within, 2], ".", color=SEEN, markersize=1.5, label="accelerometer")
    rows[3].plot(force.t[within], -force.model[within, 2], ".", color=MODEL, markersize=1.5, label="model")
    rows[3].set_ylabel("specific force up, m/s^2", color=FAINT, fontsize=9)
    rows[3].set_xlabel("s of the log", color=FAINT, fontsize=9)
    for axes in rows:
        _plain(axes)
    return figure


def _liveliest(t: NDArray[np.float64], asked: NDArray[np.float64]) -> float:
    """s: where the stretch begins in which most was asked."""
    energy = np.cumsum(np.sum(asked**2, axis=1))
    n = min(len(t) - 1, int(SHOWN / (t[1] - t[0])))
    return float(t[int(np.argmax(energy[n:] - energy[: len(energy) - n]))])


def _plain(axes: Any) -> None:
    axes.legend(loc="upper right", fontsize=8, ncols=3, frameon=False)
    axes.grid(True, color="#dde3e8", linewidth=0.8)
    axes.tick_params(labelsize=8, colors=FAINT)
