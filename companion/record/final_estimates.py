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


def final_estimates(estimated: Columns) -> dict[str, Any] | None:
    """The last estimates of following, and the pace; None for an output that estimates nothing."""
    if not len(estimated["t"]) or "thrust_scale" not in estimated or not math.isfinite(estimated["thrust_scale"][-1]):
        return None
    pace = estimated["pace"]
    return {
        "thrust_scale": float(estimated["thrust_scale"][-1]),
        "drag_per_s": float(estimated["drag"][-1]),
        "disturbance_mps2": [float(estimated[f"push_{axis}"][-1]) for axis in ("north", "east", "down")],
        "delay_s": float(estimated["delay"][-1]),
        "rate_loop_lag_s": _last(estimated, "rate_lag"),
        "yaw_loop_lag_s": _last(estimated, "yaw_lag"),
        "motor_lag_s": _last(estimated, "motor_lag"),
        "path_pole_per_s": None if _last(estimated, "path_pole") is None else _poles(estimated["path_pole"]),
        "pace": {"min": float(np.min(pace)), "slowed_fraction": float(np.mean(pace < SLOWED))},
    }


def _last(estimated: Columns, column: str) -> float | None:
    """The last value; None where the record has none."""
    return float(estimated[column][-1]) if column in estimated and math.isfinite(estimated[column][-1]) else None


def _poles(values: NDArray[np.float64]) -> dict[str, float]:
    finite = values[np.isfinite(values)]
    return {"chosen": float(finite[0]), "last": float(finite[-1])}


def estimate_sentences(figures: dict[str, Any] | None, vehicle: Vehicle) -> list[str]:
    """The same in sentences."""
    if figures is None:
        return []
    north, east, down = figures["disturbance_mps2"]
    lag = figures["rate_loop_lag_s"]  # none at motors and torques
    lags = "" if lag is None else f"rate loop lag {1e3 * lag:.0f} ms (file {1e3 * vehicle.rate_loop_lag:.0f}), "
    motor_lag = figures["motor_lag_s"]
    if motor_lag is not None:
        lags += f"motor lag {1e3 * motor_lag:.0f} ms (file {1e3 * vehicle.motor_lag:.0f}), "
    words = [
        f"found in flight: thrust scale {figures['thrust_scale']:.3f}, drag {figures['drag_per_s']:.2f} 1/s "
        f"(file {vehicle.drag:.2f}), disturbance {math.hypot(north, east, down):.2f} m/s^2, "
        f"{lags}delay from a state to its command's effect {1e3 * figures['delay_s']:.0f} ms"
    ]
    poles = figures["path_pole_per_s"]
    if poles is not None:
        chosen, last = poles["chosen"], poles["last"]
        lowered = f", lowered to {last:.1f} by the noise in the commands" if last > chosen + 0.05 else ""
        words.append(f"gains: auto: the path's poles at {chosen:.1f} 1/s{lowered}")
    pace = figures["pace"]
    if pace["slowed_fraction"] > 0.0:
        words.append(
            f"the speed gave way, to {100.0 * pace['min']:.0f} % of the mission's at least and for "
            f"{100.0 * pace['slowed_fraction']:.0f} % of the time: the vehicle could not have held the path faster"
        )
    return words
