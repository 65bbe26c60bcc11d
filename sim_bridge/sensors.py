"""Truth -> the estimate the autopilot flies by and reports.

The truth plus the world's errors, plus what resets have moved. In a world without errors the estimate is the truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from companion.frames import Quaternion, Vec3, from_rotation_vector, multiply
from companion.world.estimate import Drift, Errors, Noise
from companion.world.events import EstimatorReset
from sim_bridge.noise import Draw, SecondOrder, first_order
from sim_bridge.plant import Truth

RESETS_OF_A_BOOT = 11
"""What the reset counter stands at when an estimator has come up; PX4's stays there in flight."""
ZERO: Vec3 = (0.0, 0.0, 0.0)
"""No error."""


class Estimate(NamedTuple):
    """The vehicle's idea of its state. ``time_us``: the vehicle's clock; ``a_n`` m/s^2; ``resets``: 0..255;
    ``f_b_error``: m/s^2, of its accelerometer."""

    time_us: int
    p_n: Vec3
    v_n: Vec3
    a_n: Vec3
    q_nb: Quaternion
    w_b: Vec3
    resets: int
    f_b_error: Vec3 = ZERO


def exact(truth: Truth) -> Estimate:
    """An estimate without errors."""
    time_us = round(truth.t_boot * 1e6)
    return Estimate(time_us, truth.p_n, truth.v_n, truth.a_n, truth.q_nb, truth.w_b, RESETS_OF_A_BOOT)


Wrong = Callable[[], Vec3]
"""The next error of a vector."""


class Sensors:
    """The estimator of one vehicle, called once a ``step`` (s). ``draw``: the source of its errors."""

    def __init__(self, errors: Errors, step: float, draw: Draw) -> None:
        noise = [_noise(each, step, draw) for each in (errors.position, errors.velocity, errors.attitude, errors.gyro)]
        self._position, self._velocity, self._attitude, self._gyro = noise
        self._drift = _drift(errors.drift, step, draw) if errors.drift else None
        self._accelerometer = _noise(errors.accelerometer, step, draw)
        self._in_world = errors.attitude_in_world
        self._errs = bool(errors)
        self._moved = False
        self._p_moved: Vec3 = ZERO
        self._v_moved: Vec3 = ZERO
        self._q_turned: Quaternion = (1.0, 0.0, 0.0, 0.0)
        self._ahead_us = 0
        self._resets = RESETS_OF_A_BOOT

    def observe(self, truth: Truth) -> Estimate:
        """The estimate after a step."""
        t_boot, p_n, v_n, a_n, q_nb, w_b, _, _ = truth
        time_us = max(0, round(t_boot * 1e6) + self._ahead_us)
        if not (self._errs or self._moved):
            return Estimate(time_us, p_n, v_n, a_n, q_nb, w_b, self._resets)
        if self._position is not None:
            p_n = _sum(p_n, self._position())
        if self._drift is not None:
            p_n = _sum(p_n, self._drift())
        if self._velocity is not None:
            v_n = _sum(v_n, self._velocity())
        if self._attitude is not None:
            wrong = from_rotation_vector(self._attitude())
            q_nb = multiply(wrong, q_nb) if self._in_world else multiply(q_nb, wrong)
        if self._gyro is not None:
            w_b = _sum(w_b, self._gyro())
        f_b_error = ZERO if self._accelerometer is None else self._accelerometer()
        if self._moved:
            p_n, v_n = _sum(p_n, self._p_moved), _sum(v_n, self._v_moved)
            q_nb = multiply(self._q_turned, q_nb)
        return Estimate(time_us, p_n, v_n, a_n, q_nb, w_b, self._resets, f_b_error)

    def reset(self, event: EstimatorReset) -> None:
        """The estimate jumps. As in PX4 each of velocity, position and heading counts, level and vertical apart."""
        (x, y, z), (u, v, w) = event.position_n, event.velocity_n
        counts = sum(map(bool, (x or y, z, u or v, w, event.yaw)))
        if event.counted:
            self._resets = (self._resets + counts) & 0xFF
        self._p_moved = _sum(self._p_moved, event.position_n)
        self._v_moved = _sum(self._v_moved, event.velocity_n)
        half = 0.5 * event.yaw
        self._q_turned = multiply((math.cos(half), 0.0, 0.0, math.sin(half)), self._q_turned)
        self._moved = True

    def jump(self, by: float) -> None:
        """The stamps are ``by`` s further from now on, but never before the boot."""
        self._ahead_us += round(by * 1e6)


def _sum(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _noise(noise: Noise, step: float, draw: Draw) -> Wrong | None:
    """White noise, a wander and a bias together; None where there is none of them."""
    if not noise:
        return None
    a, b, c = noise.white
    wander = _wander(noise, step, draw) if any(noise.wander) or any(noise.start or ZERO) else None
    bias: Vec3 = (0.0, 0.0, 0.0)
    if any(noise.bias):
        x, y, z = noise.bias
        bias = (x * draw(), y * draw(), z * draw())
    x, y, z = bias
    if wander is None:
        return (lambda: (a * draw() + x, b * draw() + y, c * draw() + z)) if any(noise.white) else lambda: bias
    if not any(noise.white):
        return lambda: _sum(wander(), bias)

    def wrong() -> Vec3:
        i, j, k = wander()
        return (i + a * draw() + x, j + b * draw() + y, k + c * draw() + z)

    return wrong


def _wander(noise: Noise, step: float, draw: Draw) -> Wrong:
    """The wander; where it begins larger or smaller than it stays, in that proportion."""
    process = _smooth if noise.smooth else _rough
    if noise.start is None:
        return process(noise.wander, step, noise.wander_time, draw)
    unit = process((1.0, 1.0, 1.0), step, noise.wander_time, draw)
    (a, b, c), (i, j, k), keep = noise.wander, noise.start, math.exp(-step / noise.start_time)
    begun = (i - a, j - b, k - c)

    def settling() -> Vec3:
        nonlocal begun
        (i, j, k), (x, y, z) = begun, unit()
        begun = (keep * i, keep * j, keep * k)
        return (x * (a + i), y * (b + j), z * (c + k))

    return settling


def _drift(drift: Drift, step: float, draw: Draw) -> Wrong:
    """A wander smooth enough to have a velocity: the standard deviation of that is the wander's over its time."""
    x, y, z = drift.speed
    return _smooth((x * drift.time, y * drift.time, z * drift.time), step, drift.time, draw)


def _rough(sigma: Vec3, step: float, time: float, draw: Draw) -> Wrong:
    """Three first-order processes that share their time constant (see FirstOrder)."""
    a, b, c = sigma
    keep, kick = first_order(step / time)
    x, y, z = draw(), draw(), draw()

    def wander() -> Vec3:
        nonlocal x, y, z
        x = keep * x + kick * draw()
        y = keep * y + kick * draw()
        z = keep * z + kick * draw()
        return (a * x, b * y, c * z)

    return wander


def _smooth(sigma: Vec3, step: float, time: float, draw: Draw) -> Wrong:
    """y of SecondOrder, which has a variance of 1 / 2 and its derivative one of 1 / (2 time^2)."""
    x, y, z = (math.sqrt(2.0) * s for s in sigma)
    i, j, k = (SecondOrder(draw, step, time) for _ in range(3))

    def wander() -> Vec3:
        i.update()
        j.update()
        k.update()
        return (x * i.y, y * j.y, z * k.y)

    return wander
