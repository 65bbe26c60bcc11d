"""What a path asks of a vehicle that flies it exactly: the reference of Lemma 4.4 at many places at once, with drag."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from companion.allocation import Allocation
from companion.calculus.straight import ArrayFunction, Tape
from companion.calculus.vectors import Vector
from companion.feasibility.stations import Stations
from companion.frames import Heading
from companion.law.motion import Model
from companion.law.reference import reference_over_arc
from companion.vehicle import Vehicle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Demand:
    """What flying asks for, at n places."""

    thrust: Array  # N
    tilt: Array  # rad
    rates: Array  # rad/s (3, n), body
    torques: Array  # N m (3, n), body
    motors: Array  # shares of each rotor's command range (4, n)
    yaw_rate: Array  # rad/s, of the heading
    yaw_acceleration: Array  # rad/s^2, of the heading
    acceleration: Array  # m/s^2, the paper's V-dot
    along: Array  # m/s^2, its part along the path
    speed: Array  # m/s


def compute_demand(stations: Stations, vehicle: Vehicle, scale: float = 1.0) -> Demand:
    """The demand at every station, the whole speed multiplied by ``scale``. nan or inf where the law is singular."""
    alpha, beta = stations.alpha * scale, stations.beta
    jx, jy, jz = vehicle.inertia
    parameters = (vehicle.mass, jx, jy, jz, vehicle.gravity, vehicle.drag, *stations.wind_n)
    values = _record(stations.heading)(*stations.path[1:].reshape(12, -1), *alpha, *beta, *parameters)
    thrust, down = values[0], values[1]
    torques = values[5:8]
    return Demand(
        thrust=thrust,
        tilt=np.arccos(np.clip(down, -1.0, 1.0)),
        rates=values[2:5],
        torques=torques,
        motors=_motors(vehicle, np.concatenate([thrust[None], torques])),
        yaw_rate=beta[1] * alpha[0],
        yaw_acceleration=beta[2] * alpha[0] ** 2 + beta[1] * alpha[0] * alpha[1],
        acceleration=values[8],
        along=alpha[0] * alpha[1],
        speed=np.abs(alpha[0]),
    )


def without_yaw(asked: Demand, vehicle: Vehicle) -> Array:
    """``motors`` where nothing turns the vehicle about its thrust axis."""
    level = asked.torques * np.array([[1.0], [1.0], [0.0]])
    return _motors(vehicle, np.concatenate([asked.thrust[None], level]))


def _motors(vehicle: Vehicle, wrench: Array) -> Array:
    """Commands as shares of their ranges."""
    torques = np.array(Allocation(vehicle).inverse) @ wrench
    rows = []
    for rotor, torque in zip(vehicle.rotors, torques, strict=True):
        low, high = rotor.command
        rows.append((torque / (rotor.torque_per_thrust * rotor.thrust_max) - low) / (high - low))
    return np.stack(rows)


@cache
def _record(heading: Heading) -> ArrayFunction:
    """(four derivatives of the path, alpha 4, beta 3, mass, inertia, g, drag, wind) -> zeta, R22, w, torque, |A|."""
    tape = Tape()
    path = [Vector(0.0, 0.0, 0.0), *(Vector(*tape.inputs(*(f"c{k}{axis}" for axis in "xyz"))) for k in range(1, 5))]
    alpha = tape.inputs("a0", "a1", "a2", "a3")
    beta = tape.inputs("b0", "b1", "b2")
    m, jx, jy, jz, g, c, *wind = tape.inputs("m", "jx", "jy", "jz", "g", "c", "wx", "wy", "wz")
    there = reference_over_arc(path, alpha, beta, Model(m, Vector(jx, jy, jz), g, c), heading, Vector(*wind))
    outputs = [there.zeta, there.R.e3.z, *there.w.components(), *there.torque.components(), there.A.norm()]
    return tape.array_function("demand", outputs)
