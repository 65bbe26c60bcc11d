"""A flight in sih_noisy on rotors whose curve THR_MDL_FAC does not know of, and what is found of it."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from companion.daemon.conductor import Conductor
from companion.steering.rates import RateMemory
from sim_bridge.plant import Truth
from trials.measured import Measured, course, machine, measure_flight, steady_wind, world

HOVERS = (1.0, 1.15, 0.85)
"""The file's hover thrust over the true one of a rotor without a curve."""
LOOKED_AT = (3.0, 6.0, 10.0, 20.0, 40.0)
"""s after the hand-over."""


class Flown(NamedTuple):
    """``true``: the slope beyond proportion at the hover as told. ``found``: (slope, deviation) at LOOKED_AT."""

    true: float
    found: tuple[tuple[float, float], ...]
    flight: Measured


def flown(mission: str, speed: float, curve: float, seed: int, duration: float = 40.0) -> Flown:
    """A flight, and what it found."""
    file, where = machine("sih"), world("sih_noisy")
    assert file.limits is not None and file.hover_thrust is not None
    hover = file.hover_thrust * HOVERS[seed % len(HOVERS)]
    file = dataclasses.replace(file, hover_thrust=hover)
    if speed > 6.0:
        file = dataclasses.replace(file, limits=dataclasses.replace(file.limits, tilt=math.radians(60.0)))
    truth = dataclasses.replace(where.truth, thrust_curve=curve)
    where = dataclasses.replace(where, wind_n=steady_wind(3.0, seed), truth=truth)
    rows: list[tuple[float, float, float]] = []

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        steered = conductor.last.outcome.steered if conductor.last is not None else None
        if steered is not None and isinstance(steered.memory, RateMemory):
            slope, variance = steered.memory.estimate.motion.estimator.thrust_curve
            rows.append((now, slope, math.sqrt(variance)))

    flight = measure_flight(course(mission, speed), file, where, seed=seed, duration=duration, settle=10.0, watch=watch)
    t, slope, std = np.array(rows).T
    at = [min(int(np.searchsorted(t, t[0] + after)), len(t) - 1) for after in LOOKED_AT]
    true = curve * hover / (1.0 - curve + curve * hover)
    return Flown(true, tuple((float(slope[i]), float(std[i])) for i in at), flight)
