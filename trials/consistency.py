"""How right the estimator is about its vehicle, and whether it knows: flights in a noisy world with wrong files.

Truth is known of the stand-in: thrust scale, drag, and the disturbance, which is the wind's drag and what the tilt error
of the vehicle's own estimate explains (what its heading error explains is a number of its own in the filter). NEES is
that of (scale, drag, disturbance), five numbers; NIS that of what is predicted a state and a second ahead.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.daemon.conductor import Conductor
from companion.estimation.kalman import Belief
from companion.estimation.kalman_step import AXES, DISTURBANCE, DRAG, GUST, PER_AXIS, SIZE, THRUST_SCALE
from companion.flight.phases import Phase
from companion.frames import Quaternion, Vec3, body_z_axis, conjugate, multiply, normalised
from companion.steering.rates import RateSteering
from companion.world import World
from sim_bridge.bridge import Bridge
from sim_bridge.plant import Plant, Truth
from trials.measured import Measured, course, machine, measure_flight
from trials.prediction import Forecast

AHEAD = 1.0
"""s of the longer predictions: where the coloured errors of the vehicle's estimate show."""
STEEP = 8.5
"""m/s of speed and wind together. Beyond it the circle of 5 m needs more tilt than the vehicle file of `sih` allows."""
WINDOW = 5.0
"""s over which errors are averaged."""
NEES_BOUNDS = (0.831, 12.833)
"""95 % of chi squared with five degrees of freedom."""


class Window(NamedTuple):
    """Means over WINDOW s. ``begin``: s since following began. ``scale``, ``drag``: relative errors. ``disturbance``:
    m/s^2, the largest axis. ``nees``: of (scale, drag, disturbance); ``inside``: the share of the time within its
    bounds."""

    begin: float
    scale: float
    drag: float
    disturbance: float
    nees: float
    inside: float


class Trial(NamedTuple):
    """A flight, and how right its estimator was. ``nis``, ``nis_second``: normalised innovations squared of predictions
    one state and AHEAD s long, while following. ``scale``: s since following began, relative error of the thrust scale
    and its true value, every 20 ms."""

    flight: Measured
    windows: tuple[Window, ...]
    nis: tuple[float, ...]
    nis_second: tuple[float, ...]
    scale: NDArray[np.float64]

    def scale_error(self, after: float) -> float:
        """Of the thrust scale, relative, ``after`` s after its true value stepped."""
        t, error, true = self.scale.T
        stepped = t[np.argmax(np.abs(np.diff(true))) + 1]
        return float(error[np.argmin(np.abs(t - stepped - after))])


def trial(
    mission: str, speed: float, where: World, *, hover: float = 1.0, drag: float = 1.0, seed: int = 0,
    duration: float = 60.0,
) -> Trial:  # fmt: skip
    """Fly the SIH vehicle at rates. ``hover``, ``drag``: the vehicle file's over the true ones. Beyond STEEP the file
    has a tilt of 60 deg."""
    true = machine("sih")
    believed = dataclasses.replace(true, drag=true.drag * drag, hover_thrust=(true.hover_thrust or 0.5) * hover)
    if speed + math.hypot(*where.wind_n) > STEEP and believed.limits is not None:
        believed = dataclasses.replace(believed, limits=dataclasses.replace(believed.limits, tilt=math.radians(60.0)))
    where = dataclasses.replace(where, truth=dataclasses.replace(where.truth, drag=true.drag))
    rows: list[tuple[float, ...]] = []
    scales: list[float] = []
    forecasts = Forecast(0.0, true.gravity), Forecast(AHEAD, true.gravity)
    plants: list[Plant] = []

    def prepare(_: Conductor, bridge: Bridge) -> None:
        plants.append(bridge.plant)

    def watch(conductor: Conductor, truth: Truth, now: float) -> None:
        memory = conductor.memory
        if memory is None or memory.phase is not Phase.FOLLOW or memory.path.follow_from is None:
            return
        known = memory.steering.memory.estimate
        for forecast in forecasts:
            forecast.take(known.motion.state, known.rate_loop_state.specific_thrust, known.motion.estimator)
        if rows and truth.t_boot - memory.path.follow_from - rows[-1][0] < 0.02:
            return
        steering = conductor.plan.steering if conductor.plan is not None else None
        assert isinstance(steering, RateSteering)
        estimate, (plant,) = known.motion, plants
        scale, c = steering.hover_thrust * thrust_max(plant) / plant.vehicle.weight, plant.vehicle.drag
        thrust = truth.thrust / plant.vehicle.mass
        pushed = np.multiply(c, plant.wind_n) + np.multiply(thrust, leaning(truth.q_nb, estimate.state.q_nb))
        made = known.rate_loop_state.specific_thrust
        flown = made / estimate.estimator.thrust_curve.command_for(made, true.gravity)
        error = errors(estimate.estimator.belief, scale, c, pushed, flown)
        rows.append((truth.t_boot - memory.path.follow_from, *error))
        scales.append(scale)

    flight = measure_flight(
        course(mission, speed), believed, where, seed=seed, duration=duration, prepare=prepare, watch=watch
    )
    nis, nis_second = (tuple(value for _, value in forecast.found) for forecast in forecasts)
    found = np.array(rows) if rows else np.zeros((0, 7))
    return Trial(
        flight, windows(found) if rows else (), nis, nis_second, np.column_stack((found[:, 0], found[:, 1], scales))
    )


def thrust_max(plant: Plant) -> float:
    """N, of all rotors at their highest command as they are now: sagging, failing."""
    a, b, c, d = (rotor.command[1] for rotor in plant.vehicle.rotors)
    return sum(plant.thrusts_of((a, b, c, d)))


def errors(
    belief: Belief, scale: float, drag: float, pushed: NDArray[np.float64], flown: float = 1.0
) -> tuple[float, ...]:
    """Of scale and drag, relative; of the disturbance (m/s^2, three axes); NEES of the five. ``flown``: the thrust made
    over thrust commanded as it is flown, over that of the hover as told: what the thrust curve makes of it."""
    error = np.array(
        [flown * belief.thrust_scale - scale, belief.drag - drag, *np.subtract(belief.disturbance_n, pushed)]
    )
    nees = float(error @ np.linalg.solve(covariance(belief), error))
    return (error[0] / scale, error[1] / drag, *error[2:], nees)


def leaning(q_nb: Quaternion, seen: Quaternion) -> Vec3:
    """The thrust axis as seen, the heading error (the turn about the vertical) taken out, minus the true one."""
    w, x, y, _ = multiply(seen, conjugate(q_nb))
    tilted = multiply((w, x, y, 0.0), q_nb)
    (a, b, c), (i, j, k) = body_z_axis(normalised(tilted)), body_z_axis(q_nb)
    return (a - i, b - j, c - k)


def covariance(belief: Belief) -> NDArray[np.float64]:
    """Of (scale, drag, D + W of each axis)."""
    P = np.array(belief.covariance())
    H = np.zeros((2 + AXES, SIZE))
    H[0, THRUST_SCALE] = H[1, DRAG] = 1.0
    for axis in range(AXES):
        H[2 + axis, [PER_AXIS * axis + DISTURBANCE, PER_AXIS * axis + GUST]] = 1.0
    result: NDArray[np.float64] = H @ P @ H.T
    return result


def windows(rows: NDArray[np.float64]) -> tuple[Window, ...]:
    """``rows``: s since following began, and the errors there."""
    result = []
    for begin in np.arange(0.0, rows[-1, 0] - WINDOW + 0.1, WINDOW):
        part = rows[(rows[:, 0] >= begin) & (rows[:, 0] < begin + WINDOW)]
        mean = part.mean(axis=0)
        inside = float(np.mean((part[:, 6] > NEES_BOUNDS[0]) & (part[:, 6] < NEES_BOUNDS[1])))
        result.append(
            Window(float(begin), mean[1], mean[2], float(np.abs(mean[3:6]).max()), float(np.median(part[:, 6])), inside)
        )
    return tuple(result)
