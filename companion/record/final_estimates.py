"""What a flight found out of its vehicle, and where the speed gave way: figures for the summary, words for people."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.estimation.thrust_curve import model_factor
from companion.vehicle import Vehicle

SLOWED = 0.99
"""The share of the mission's speed below which it counts as having given way."""

CURVE_STD_MAX = 0.05
"""Ratio: standard deviation of the thrust curve above which nothing is said of THR_MDL_FAC. Engineering choice."""
CURVE_SIGMAS = 3.0
"""Number of its standard deviations that the thrust curve is to be off by for that. Engineering choice."""
FACTOR_STEP = 0.05
"""Ratio: the least change of THR_MDL_FAC that is worth a word. Engineering choice."""

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
        "thrust_curve": _last(estimated, "thrust_curve"),
        "thrust_curve_std": _last(estimated, "thrust_curve_std"),
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
    curve, curve_std = figures["thrust_curve"], figures["thrust_curve_std"]
    if curve is not None:
        lags += f"thrust curve {curve:+.2f} +- {curve_std:.2f} beyond proportion, "
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


def curve_sentences(figures: dict[str, Any] | None, told: float | None, hover_thrust: float) -> list[str]:
    """What THR_MDL_FAC should be, where the flight knows that it is wrong. ``told``: as PX4 has it, None where it did
    not say. ``hover_thrust``: normalised, as PX4 or the vehicle file has it."""
    curve, std = (None, None) if figures is None else (figures["thrust_curve"], figures["thrust_curve_std"])
    if told is None or curve is None or std is None or std > CURVE_STD_MAX or abs(curve) < CURVE_SIGMAS * std:
        return []
    factor = model_factor(curve, hover_thrust, told)
    if abs(factor - told) < FACTOR_STEP:
        return []
    return [
        f"thrust is not proportional to its command (its slope {100.0 * curve:+.0f} % off), which was reckoned with: "
        f"THR_MDL_FAC {factor:.2f} in the place of {told:.2f} would make it so"
    ]
