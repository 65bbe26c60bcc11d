"""Hover thrust, drag, thrust curve and battery, from the accelerometer.

    f_b = -thrust(u) e3 + R^T (d - c v) + b

``thrust(u)``: m/s^2, one g at the hover thrust h, lagged by the motors. PX4 makes a motor command s of the thrust
setpoint u by its THR_MDL_FAC f, u = f s^2 + (1 - f) s; the propeller makes m s^2 + (1 - m) s of it: with f = m
thrust is linear in u. ``d``: wind times drag, NED; ``b``: the accelerometer's bias. Air seldom pushes a quadrotor up or
down, and PX4 takes most of the bias out: both have priors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.identification.flight_data import STEP, Part, telling
from companion.identification.least_squares import Array, fit
from companion.identification.rate_fit import BLOCK, Found, blocks_of, first_order, seconds
from companion.vehicle import GRAVITY, CompanionError

VERTICAL_STD, BIAS_STD = 0.15, 0.1
"""m/s^2: what is believed beforehand of a steady push from above, and of the bias."""
CURVE_RANGE_MIN = 0.12
"""Standard deviation of the thrust over its mean from which on a curve is looked for."""
VOLTS_RANGE_MIN = 0.3
"""V between the 5th and 95th percentile from which on the battery's share is looked for."""
VOLTS_WINDOW = 8.0
"""s over which the voltage is averaged. It falls by 0.2 to 0.4 V whenever the motors pull (a QAV250's logs): that is no
battery that empties, and hides one (engineering choice)."""
SLOW_ERROR = 0.01
"""Ratio of the thrust by which a VOLTS_WINDOW may err as a whole: a QAV250's residuals average to 1 to 2 % over 4 s."""
SAMPLES = 4000
"""of the accelerometer are looked at, spread over the flight; more cost time and tell no more (engineering choice)."""
SAMPLES_MIN = 20
"""Number of them from which on anything is fitted. Engineering choice: 1 s by PX4's default profile, six times as many
figures as there are unknowns."""
FILTER_DELAY = np.sqrt(2.0) / (2.0 * np.pi)
"""Delay times cutoff of a second-order Butterworth low-pass."""


class ForceFit(NamedTuple):
    """``hover_thrust``: normalised. ``drag``: 1/s. ``motor_lag``: s. ``curve``: m, None where the thrust hardly
    changed. ``per_volt``: relative change of the thrust a volt, None where the voltage hardly changed. ``volts``: the
    mean. ``disturbance_n``: m/s^2. ``thrust_spread``: standard deviation over mean. ``speed``: m/s, its RMS.
    ``seen``, ``model``: m/s^2, specific force along each body axis with time ``t``, s."""

    hover_thrust: Found
    drag: Found
    motor_lag: Found
    curve: Found | None
    per_volt: Found | None
    volts: float
    disturbance_n: Array
    thrust_spread: float
    speed: float
    t: Array
    seen: Array
    model: Array


class _Data(NamedTuple):
    """The parts laid end to end, at the accelerometer's samples. ``volts``: averaged over VOLTS_WINDOW."""

    kept: list[NDArray[np.bool_]]
    force: Array
    r_nb: Array
    v_n: Array
    volts: Array
    blocks: NDArray[np.int64]


def fit_forces(parts: Sequence[Part], parameters: Mapping[str, float], motor_lag: Found) -> ForceFit:
    """``motor_lag``: as the torques tell it. CompanionError: too little of the flight tells."""
    data = _laid_end_to_end(parts)
    thrust = np.concatenate([part.thrust[k] for part, k in zip(parts, data.kept, strict=True)])
    spread = float(np.std(thrust) / np.mean(thrust))
    has_volts = np.isfinite(data.volts).all() and np.ptp(np.percentile(data.volts, (5, 95))) > VOLTS_RANGE_MIN
    curved = spread > CURVE_RANGE_MIN
    told = parameters.get("THR_MDL_FAC", 0.0)
    delay = round(FILTER_DELAY / max(parameters.get("IMU_ACCEL_CUTOFF", 30.0), 5.0) / STEP)
    mean_volts = float(np.mean(data.volts)) if has_volts else float("nan")
    weights = np.ones(3)

    def model(theta: Array) -> Array:
        h, c, lag, curve, per_volt = theta[:5]
        lifted = []
        for part, kept in zip(parts, data.kept, strict=True):
            force = GRAVITY * _made(part.thrust, told, curve) / _made(np.array([h]), told, curve)[0]
            late = first_order(force, lag, force[0])
            lifted.append(np.concatenate([np.full(delay, late[0]), late[: len(late) - delay]])[kept])
        lift = np.concatenate(lifted)
        if has_volts:
            lift = lift * (1.0 + per_volt * (data.volts - mean_volts))
        pushed: Array = np.einsum("nji,nj->ni", data.r_nb, theta[5:8] - c * data.v_n) + theta[8:11]
        pushed[:, 2] -= lift
        return pushed

    priors = (
        (2, motor_lag.value, max(motor_lag.std, 0.002)), (3, told, 0.3 if curved else 1e-6),
        (4, 0.0, 0.2 if has_volts else 1e-6), (7, 0.0, VERTICAL_STD), *((k, 0.0, BIAS_STD) for k in (8, 9, 10)),
    )  # fmt: skip

    def misses(theta: Array) -> Array:
        rows = ((model(theta) - data.force) * weights).ravel()
        # a prior weighs as much as it says, however many samples there are
        return np.concatenate([rows, [(theta[k] - mean) / std for k, mean, std in priors]])

    start = [parameters.get("MPC_THR_HOVER", float(np.mean(thrust))), 0.3, motor_lag.value, told, *[0.0] * 7]
    low = [0.03, 0.0, 0.002, 0.0, -1.0, *[-20.0] * 3, *[-2.0] * 3]
    high = [0.97, 5.0, 0.2, 1.0, 1.0, *[20.0] * 3, *[2.0] * 3]
    last = int(data.blocks.max()) + 1
    blocks = np.concatenate([np.repeat(data.blocks, 3), last + np.arange(len(priors))]).astype(np.int64)
    scale = [0.1, 0.3, 0.02, 0.2, 0.1, *[1.0] * 3, *[0.1] * 3]
    found = fit(misses, blocks, start, low, high, scale)
    for _ in range(2):
        residuals = model(found.values) - data.force
        weights = 1.0 / np.maximum(np.std(residuals, axis=0), 0.02) / np.sqrt(_correlated(residuals, data))
        found = fit(misses, blocks, found.values.tolist(), low, high, scale)
    each = [Found(float(v), float(s)) for v, s in zip(found.values, found.std, strict=True)]
    return ForceFit(
        each[0], each[1], each[2], each[3] if curved else None, _per_volt(each[4], data) if has_volts else None,
        mean_volts, found.values[5:8], spread, float(np.sqrt(np.mean(np.sum(data.v_n**2, axis=1)))),
        np.concatenate([part.t[k] for part, k in zip(parts, data.kept, strict=True)]), data.force, model(found.values),
    )  # fmt: skip


def _made(u: Array, told: float, curve: float) -> Array:
    """What a propeller of ``curve`` makes of thrust setpoints that PX4 turned into commands by ``told``, in units of
    its most."""
    u = np.clip(u, 0.0, 1.0)
    rest = 1.0 - told
    command = u if told < 1e-6 else (np.sqrt(rest * rest + 4.0 * told * u) - rest) / (2.0 * told)
    made: Array = curve * command * command + (1.0 - curve) * command
    return made


def _laid_end_to_end(parts: Sequence[Part]) -> _Data:
    kept = [part.accelerometer_new & telling(part) for part in parts]
    count = sum(int(k.sum()) for k in kept)
    if count < SAMPLES_MIN:
        told, flown = seconds([telling(part) for part in parts]), STEP * sum(len(part.t) for part in parts)
        raise CompanionError(
            f"too little of the log tells anything: of {flown:.1f} s in the air the motors were off their limits for "
            f"{told:.1f} s, with {count} samples of the accelerometer; {SAMPLES_MIN} are needed. Nothing was written. "
            "Fly longer and gentler, half a minute at least, with SDLOG_PROFILE 25"
        )
    every = max(1, count // SAMPLES)
    kept = [k & (np.cumsum(k) % every == 0) for k in kept]

    def joined(name: str) -> Array:
        return np.concatenate([getattr(part, name)[k] for part, k in zip(parts, kept, strict=True)])

    blocks = np.concatenate([b[k] for b, k in zip(blocks_of(parts), kept, strict=True)])
    volts = np.concatenate([_averaged(part.volts)[k] for part, k in zip(parts, kept, strict=True)])
    return _Data(kept, joined("accelerometer"), joined("r_nb"), joined("v_n"), volts, blocks)


def _averaged(volts: Array) -> Array:
    """The mean over VOLTS_WINDOW about each step of the grid, as far as there are steps."""
    half, steps = round(0.5 * VOLTS_WINDOW / STEP), np.arange(len(volts))
    first, last = np.maximum(steps - half, 0), np.minimum(steps + half + 1, len(volts))
    total = np.concatenate([[0.0], np.cumsum(volts)])
    averaged: Array = (total[last] - total[first]) / (last - first)
    return averaged


def _per_volt(found: Found, data: _Data) -> Found:
    """With the doubt that slow errors of the thrust leave, of which the blocks know nothing."""
    windows = max(1.0, BLOCK * len(np.unique(data.blocks)) / VOLTS_WINDOW)
    return Found(found.value, float(np.hypot(found.std, SLOW_ERROR / (np.std(data.volts) * np.sqrt(windows)))))


def _correlated(residuals: Array, data: _Data) -> float:
    """How many samples err as one: the variance of the means of blocks beside what white residuals would have."""
    count = int(data.blocks.max()) + 1
    sums = np.zeros((count, 3))
    np.add.at(sums, data.blocks, residuals - residuals.mean(axis=0))
    sizes = np.bincount(data.blocks, minlength=count)[:, None]
    expected = np.maximum(np.var(residuals, axis=0) * sizes, 1e-12)
    return float(np.clip(np.mean(sums**2 / expected), 1.0, 1e4))
