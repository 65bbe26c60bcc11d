"""The lag and the gain of the vehicle's rate loop, found from how its body rates follow what was meant.

Three models run side by side with lags L/d, L and L d, driven by the commands alone. Whichever misses the gyro least
says where the lag is: a parabola through their mean squared misses, over the logarithm of the lag, has its bottom
there. Noise misses all three alike and a wrong gain turns at right angles to a wrong lag, so neither moves the bottom.

The integral of PX4's rate loop lets it overshoot what changes slowly, by a few percent. How much more the vehicle turns
than the middle model is its gain, and so much less is sent than is meant.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.response import STEP, Sent, axis_step, in_force
from companion.frames import Vec3

APART = 0.25
"""Between the models, in the logarithm of the lag."""
MEAN_TIME, FOLLOW_TIME, SETTLE = 3.0, 2.0, 0.4
"""s: of the mean of the misses, of the lag towards the bottom, of the models after a new beginning."""
TELLING = (5e-4) ** 2
"""(rad/s)^2: how much deeper the parabola's bottom must lie before it says anything."""
SHORTEST, LONGEST = 0.9, 1.6
"""Times the first belief: between these the lag is sought. A slow course shows the lag of slow commands only, which the
integral of PX4's rate loop shortens, and the loop is closed over the fast ones too."""
GAIN_MAX, GAIN_TELLING = 1.1, 0.2**2
"""The gain that is believed, never less than 1; (rad/s)^2: how much must be turned before it is looked for."""
PERIOD, GAP_MAX = 0.024, 0.06
"""s between two looks, which is often enough; and without a state, after which the models begin anew."""

Axes = tuple[float, float, float, float]
"""p, p', q, q' of one model: rad/s, rad/s^2."""


class Lag(NamedTuple):
    """``value``: s. ``first``: s, the belief it began with. ``models``: with shorter, this and longer lag; ``misses``:
    their mean squares. ``ran``: s since the models began anew. ``at``: s,
    the vehicle's clock, of the last look. ``gain``: of the rate loop, by which less is sent than is meant. ``alike``,
    ``turned``: (rad/s)^2, means of gyro times middle model and of the middle model squared."""

    value: float
    first: float
    models: tuple[Axes, Axes, Axes]
    misses: Vec3 = (0.0, 0.0, 0.0)
    ran: float = 0.0
    at: float = -math.inf
    gain: float = 1.0
    alike: float = 0.0
    turned: float = 0.0


def first_lag(value: float, w_b: Vec3, first: float | None = None) -> Lag:
    """Nothing seen yet but body rates (rad/s)."""
    still = (w_b[0], 0.0, w_b[1], 0.0)
    return Lag(value, value if first is None else first, (still, still, still))


def begun_anew(lag: Lag, w_b: Vec3) -> Lag:
    """The models put back on the vehicle; what was found stays."""
    still = (w_b[0], 0.0, w_b[1], 0.0)
    return lag._replace(models=(still, still, still), ran=0.0, at=-math.inf)


def followed_lag(lag: Lag, motor_lag: float, sent: tuple[Sent, ...], now: float, w_b: Vec3) -> Lag:
    """``lag`` after the commands in force until ``now`` (s, the vehicle's clock) and a look at the gyro (rad/s).

    Of ``sent`` the commands of the last PERIOD are needed, as they were meant.
    """
    dt = now - lag.at
    if dt < PERIOD:
        return lag
    if dt > GAP_MAX:
        return begun_anew(lag, w_b)._replace(at=now)
    begin = lag.at
    value = lag.value
    # on a grid of one percent, so that the steps are computed once
    grid = round(100.0 * math.log(value))
    apart = round(100.0 * APART)
    a, b, c = (
        _run(model, math.exp(0.01 * (grid + k * apart)), motor_lag, sent, begin, dt)
        for k, model in zip((-1, 0, 1), lag.models, strict=True)
    )
    models = (a, b, c)
    ran = lag.ran + dt
    if ran < SETTLE:
        return lag._replace(models=models, ran=ran, at=now)
    k = dt / MEAN_TIME
    p, q, _ = w_b
    short, middle, long = (
        mean + k * ((m[0] - p) ** 2 + (m[2] - q) ** 2 - mean) for mean, m in zip(lag.misses, models, strict=True)
    )
    depth = short + long - 2.0 * middle
    if depth > TELLING or abs(short - long) > TELLING:
        inside = middle <= short and middle <= long and depth > 0.0
        towards = 0.5 * APART * (short - long) / depth if inside else math.copysign(APART, short - long)
        value *= math.exp(towards * dt / FOLLOW_TIME)
        value = max(lag.first * SHORTEST, min(lag.first * LONGEST, value))
    alike = lag.alike + k * (b[0] * p + b[2] * q - lag.alike)
    turned = lag.turned + k * (b[0] * b[0] + b[2] * b[2] - lag.turned)
    gain = lag.gain
    if turned > GAIN_TELLING:
        gain *= 1.0 + (alike / turned - 1.0) * dt / FOLLOW_TIME
        gain = max(1.0, min(GAIN_MAX, gain))
    return Lag(value, lag.first, models, (short, middle, long), ran, now, gain, alike, turned)


def _run(model: Axes, lag: float, motor_lag: float, sent: tuple[Sent, ...], begin: float, dt: float) -> Axes:
    steps = max(1, math.ceil(dt / (2.0 * STEP) - 1e-9))
    h = round(dt / steps, 6)
    step = axis_step(lag, motor_lag, h)
    p, pd, q, qd = model
    for k in range(steps):
        _, rates, _ = in_force(sent, begin + (k + 0.5) * h)
        yp, yq = p - rates[0], q - rates[1]
        p, pd = rates[0] + step.yy * yp + step.yd * pd, step.dy * yp + step.dd * pd
        q, qd = rates[1] + step.yy * yq + step.yd * qd, step.dy * yq + step.dd * qd
    return (p, pd, q, qd)
