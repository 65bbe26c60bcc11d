"""What a flight found out of its vehicle, and where the speed gave way: figures for the summary, words for people."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.vehicle import Vehicle

SLOWED = 0.99
"""The share of the mission's speed below which it counts as having given way."""

Columns = Mapping[str, NDArray[np.float64]]


def found(told: Columns) -> dict[str, Any] | None:
    """The last estimates of following, and the pace; None for an output that estimates nothing."""
    if not len(told["t"]) or "thrust_scale" not in told or not math.isfinite(told["thrust_scale"][-1]):
        return None
    pace = told["pace"]
    return {
        "thrust_scale": float(told["thrust_scale"][-1]),
        "drag_per_s": float(told["drag"][-1]),
        "disturbance_mps2": [float(told[f"push_{axis}"][-1]) for axis in ("north", "east", "down")],
        "delay_s": float(told["delay"][-1]),
        "rate_loop_lag_s": float(told["rate_lag"][-1]),
        "pace": {"min": float(np.min(pace)), "slowed_fraction": float(np.mean(pace < SLOWED))},
    }


def found_words(figures: dict[str, Any] | None, vehicle: Vehicle) -> list[str]:
    """The same in sentences."""
    if figures is None:
        return []
    north, east, down = figures["disturbance_mps2"]
    words = [
        f"found in flight: thrust scale {figures['thrust_scale']:.3f}, drag {figures['drag_per_s']:.2f} 1/s "
        f"(file {vehicle.drag:.2f}), disturbance {math.hypot(north, east, down):.2f} m/s^2, "
        f"rate loop lag {1e3 * figures['rate_loop_lag_s']:.0f} ms (file {1e3 * vehicle.rate_loop_lag:.0f}), "
        f"delay from a state to its command's effect {1e3 * figures['delay_s']:.0f} ms"
    ]
    pace = figures["pace"]
    if pace["slowed_fraction"] > 0.0:
        words.append(
            f"the speed gave way, to {100.0 * pace['min']:.0f} % of the mission's at least and for "
            f"{100.0 * pace['slowed_fraction']:.0f} % of the time: the vehicle could not have held the path faster"
        )
    return words
