"""The part of a log that was flown, on one grid of time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.identification.ulog import NEEDED, Log, Series
from companion.vehicle import CompanionError

Array = NDArray[np.float64]
STEP = 0.004
"""s of the grid: PX4's rate loop in simulation, and what a high-rate log has (engineering choice)."""
SETTLING = 1.0
"""s after take-off, and after a gap, that are left out: the filters swing in."""
FLOWN_MIN = 5.0
"""s: a shorter part tells nothing."""
NEAR_GROUND = 0.5
"""m of height from where it took off or landed, within which legs may carry (engineering choice)."""
CARRIED = 0.6
"""Of the median thrust, below which the ground carries a part (engineering choice)."""
GAP_MAX = 0.25
"""s without a sample of the gyro that end a part."""
MOTOR_PER_TILT_TORQUE = 0.7071
"""Of a motor's range that a roll or pitch torque setpoint of 1 takes on a quad X (PX4's normalisation); yaw takes 1."""
AFTER_SATURATION = 0.3
"""s: what a clipped command has stirred up has died out."""
THRUST_MIN = 0.08
"""Normalised thrust below which a vehicle stands, where nothing says whether it has landed."""


class Part(NamedTuple):
    """A stretch of uninterrupted flight on a grid of STEP.

    ``t``: s of the log. ``gyro``, ``rates_setpoint``: rad/s. ``torque``, ``thrust``: normalised setpoints, thrust
    upwards. ``accelerometer``: m/s^2, FRD, with ``accelerometer_new`` where a sample is a new one. ``r_nb``: rotation
    matrices, n by 3 by 3. ``v_n``: m/s. ``volts``: of the battery, or NaN. ``free``: no motor met a
    limit, now or in the last AFTER_SATURATION.
    """

    t: Array
    gyro: Array
    rates_setpoint: Array
    torque: Array
    thrust: Array
    accelerometer: Array
    accelerometer_new: NDArray[np.bool_]
    r_nb: Array
    v_n: Array
    volts: Array
    free: NDArray[np.bool_]


def flown_parts(log: Log) -> list[Part]:
    """Every stretch of flight that is long enough. CompanionError: there is none."""
    parts = [_part(log, begin, end) for begin, end in _flown(log)]
    if not parts:
        raise CompanionError(f"the log has no {FLOWN_MIN:g} s of flight in one piece")
    return parts


def telling(part: Part) -> NDArray[np.bool_]:
    """Where the filters have swung in and no motor is at a limit: of that a fit is made."""
    told: NDArray[np.bool_] = part.free & (part.t > part.t[0] + SETTLING)
    return told


def _flown(log: Log) -> list[tuple[float, float]]:
    """s, begin and end of each stretch in the air without a gap of the gyro."""
    gyro = log.topics["vehicle_angular_velocity"].t
    thrust = log.topics["vehicle_thrust_setpoint"]
    flying = np.abs(_held(thrust, gyro)[:, 0]) > THRUST_MIN
    landed = log.topics.get("vehicle_land_detected")
    stood = None if landed is None else _held(landed, gyro)[:, 0] > 0.5
    if stood is not None:
        flying &= ~stood
    for name in NEEDED:  # beyond its samples a topic says nothing
        t = log.topics[name].t
        flying &= (gyro > t[0]) & (gyro < t[-1])
    ends = np.flatnonzero(np.diff(flying.astype(int)) != 0) + 1
    cuts = np.union1d(ends, np.flatnonzero(np.diff(gyro) > GAP_MAX) + 1)
    found = []
    for first, last in zip(np.concatenate([[0], cuts]), np.concatenate([cuts, [len(gyro)]]), strict=True):
        if flying[first] and gyro[last - 1] - gyro[first] > FLOWN_MIN + SETTLING:
            began, ended = float(gyro[first]), float(gyro[last - 1])
            if stood is not None:
                began, ended = _off_the_ground(log, began, ended, bool(stood[:first].any()), bool(stood[last:].any()))
            found.append((began, ended))
    return [(began, ended) for began, ended in found if ended - began > FLOWN_MIN]


def _off_the_ground(log: Log, began: float, ended: float, took_off: bool, landed: bool) -> tuple[float, float]:
    """The part of a stretch in which its rotors carry it, well above the ground on which it begins and ends: PX4 needs
    a while to notice."""
    position = log.topics["vehicle_local_position"]
    within = (position.t >= began) & (position.t <= ended)
    t, down = position.t[within], position.x[within, 3]
    if len(t) == 0:  # nothing says how high it was
        return began, began
    thrust = np.abs(_held(log.topics["vehicle_thrust_setpoint"], t)[:, 0])
    carried = thrust > CARRIED * np.median(thrust)
    if took_off:
        above = np.flatnonzero((np.abs(down - down[0]) > NEAR_GROUND) & carried)
        began = float(t[above[0]]) if len(above) else ended
    if landed:
        above = np.flatnonzero((np.abs(down - down[-1]) > NEAR_GROUND) & carried)
        ended = float(t[above[-1]]) if len(above) else began
    return began, ended


def _free(torque: Array, thrust: Array) -> NDArray[np.bool_]:
    """Where PX4's mixer gives what is asked for."""
    share = MOTOR_PER_TILT_TORQUE * (np.abs(torque[:, 0]) + np.abs(torque[:, 1])) + np.abs(torque[:, 2])
    clipped = (thrust + share > 1.0) | (thrust < share)
    last = np.maximum.accumulate(np.where(clipped, np.arange(len(thrust)), -len(thrust)))
    free: NDArray[np.bool_] = np.arange(len(thrust)) - last > AFTER_SATURATION / STEP
    return free


def _part(log: Log, begin: float, end: float) -> Part:
    t = np.arange(begin, end, STEP)
    topics = log.topics
    accelerometer = topics["vehicle_acceleration"]
    nearest = np.searchsorted(accelerometer.t, t, side="right") - 1
    new = np.concatenate([[False], np.diff(nearest) > 0])
    battery = topics.get("battery_status")
    torque, thrust = _commanded(topics["vehicle_torque_setpoint"], t), _commanded(topics["vehicle_thrust_setpoint"], t)
    volts = np.full(len(t), np.nan) if battery is None else _linear(battery, t)[:, 0]
    return Part(
        t,
        _linear(topics["vehicle_angular_velocity"], t),
        _commanded(topics["vehicle_rates_setpoint"], t),
        torque,
        -thrust[:, 0],
        accelerometer.x[np.clip(nearest, 0, None)],
        new,
        _rotations(_linear(_continuous(topics["vehicle_attitude"]), t)),
        _linear(topics["vehicle_local_position"], t)[:, :3],
        volts,
        _free(torque, -thrust[:, 0]),
    )


def _held(series: Series, t: Array) -> Array:
    """The last sample before each ``t``."""
    held: Array = series.x[np.clip(np.searchsorted(series.t, t, side="right") - 1, 0, None)]
    return held


def _linear(series: Series, t: Array) -> Array:
    return np.column_stack([np.interp(t, series.t, column) for column in series.x.T])


def _commanded(series: Series, t: Array) -> Array:
    """A setpoint over each step of the grid: as it was held where all of them were logged; in between where only some
    were, which has no delay on the mean."""
    middle = t + 0.5 * STEP
    return _held(series, middle) if series.period < 3.0 * STEP else _linear(series, middle)


def _continuous(attitude: Series) -> Series:
    """The quaternions without their jumps of sign."""
    flips = np.sign(np.sum(attitude.x[1:] * attitude.x[:-1], axis=1))
    signs = np.concatenate([[1.0], np.cumprod(np.where(flips == 0.0, 1.0, flips))])
    return Series(attitude.t, attitude.x * signs[:, None])


def _rotations(q: Array) -> Array:
    """Rotation matrices (n, 3, 3), body to world, of quaternions (n, 4) wxyz of any length."""
    from scipy.spatial.transform import Rotation

    matrices: Array = Rotation.from_quat(np.roll(q, -1, axis=1)).as_matrix()
    return matrices
