"""The ends of a flight along a path: how the speed rises from rest, and how it comes to rest at an open end.

The start is a factor in time: a speed that rises with displacement alone never leaves rest. The stop is one in
displacement, like the mission's own speed: near the end the vehicle is asked for at most

    w(x) = k x / sqrt(1 + k^2 x / (2 a))              x: m to the end

which is sqrt(2 a x) far from the end (braking at a), k x near it (an exponential approach), and everywhere between
brakes at no more than a: w w' = a (1 - (1 + c x)^-2) with c = k^2 / (2 a). With the mission's speed alpha it is joined
smoothly into

    alpha w / (alpha^8 + w^8)^(1/8)

which is alpha to 0.2 % from three times the braking distance alpha^2 / (2 a) on, and has as many derivatives as alpha:
the law differentiates it along the motion that it measures. So no standstill before the end satisfies it. (It would if
the factor's rate were worked out from the speed that is wanted.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from companion.calculus.scalar import sqrt
from companion.calculus.straight import Function, Tape
from companion.calculus.taylor import Taylor
from companion.profiles.over_arc import Four
from companion.profiles.speed import SpeedOverArc

ACCELERATION = 1.5
"""m/s^2, a: the steepest rise of the speed at the start, and the hardest braking towards an end. Engineering choice: a
tilt of 9 degrees, which every vehicle that flies a path has to spare."""
APPROACH_RATE = 1.2
"""1/s, k: the rate of the exponential approach to an end. Engineering choice: well below the poles of the speed error
(2 1/s by default), so that the vehicle follows it; 0.35 m before the end it flies 0.4 m/s."""
START_STEEPNESS = 1.875
"""The steepest slope of the smooth step 10 t^3 - 15 t^4 + 6 t^5, in its middle."""
ARRIVED_WITHIN = 0.03
"""m: so near its end a path counts as flown in what is foretold; the hold of the end point closes in faster than w."""


@dataclass(frozen=True)
class StoppingSpeed:
    """``speed``, brought to rest at an open end of the path. ``end``: m, the arc length there; ``towards``: +1 where
    the end lies at greater arc lengths than the path, -1 where at smaller ones."""

    speed: SpeedOverArc
    end: float
    towards: float

    def at(self, s: float) -> Four:
        """See SpeedOverArc. Past the end: as at the end."""
        return self.of(s, self.speed.at(s))

    def of(self, s: float, alpha: Four) -> Four:
        """The same where the mission's speed at ``s`` is already known."""
        left = max(self.towards * (self.end - s), 0.0)
        return _stopping()(left, -self.towards, *alpha)


@cache
def _stopping() -> Function:
    """(m left, its slope over s: +-1, alpha and three derivatives over s) -> the stopping speed and three."""
    tape = Tape()
    left, slope = tape.inputs("left", "slope")
    a0, a1, a2, a3 = tape.inputs("a0", "a1", "a2", "a3")
    x = Taylor((left, slope, 0.0, 0.0))
    alpha = Taylor((a0, a1, a2 / 2.0, a3 / 6.0))
    w = x * APPROACH_RATE / sqrt(x * (APPROACH_RATE**2 / (2.0 * ACCELERATION)) + 1.0)
    stopping = alpha * w / sqrt(sqrt(sqrt(_eighth(alpha) + _eighth(w))))
    return tape.function("stopping", [stopping.derivative(k) for k in range(4)])


def _eighth(x: Taylor) -> Taylor:
    square = x * x
    fourth = square * square
    eighth: Taylor = fourth * fourth
    return eighth


def stopping_factor(speed: NDArray[np.float64], left: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a speed (m/s, any sign) is multiplied with where so much of the path (m) is left."""
    w = APPROACH_RATE * left / np.sqrt(1.0 + APPROACH_RATE**2 / (2.0 * ACCELERATION) * left)
    factor: NDArray[np.float64] = w / (speed**8 + w**8) ** 0.125
    return factor


def start_time(speed_max: float) -> float:
    """s that a start to this speed (m/s) takes."""
    return START_STEEPNESS * speed_max / ACCELERATION


def flight_time(s: NDArray[np.float64], speed: NDArray[np.float64], T: float) -> float:
    """s from rest at ``s[0]`` to rest at ``s[-1]`` (m), for a mission's ``speed`` (m/s, at each) after a start that
    takes ``T`` s."""
    end = float(s[-1]) - ARRIVED_WITHIN
    # closer together towards the end, where the speed falls with the distance that is left
    left = np.unique(np.concatenate([s[-1] - s[s < end], np.geomspace(ARRIVED_WITHIN, max(s[-1] - s[0], 0.1), 400)]))
    left = left[(left <= s[-1] - s[0]) & (left >= ARRIVED_WITHIN)]
    alpha = np.abs(np.interp(s[-1] - left, s, speed))
    slowness = 1.0 / (alpha * stopping_factor(alpha, left))
    at_speed = float(np.sum(0.5 * (slowness[1:] + slowness[:-1]) * np.diff(left)))
    # the start covers in its T what takes half as long at speed
    if T == 0.0 or at_speed >= 0.5 * T:
        return at_speed + 0.5 * T
    low, high = 0.0, T
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        t = middle / T
        low, high = (middle, high) if T * t**4 * (2.5 - 3.0 * t + t * t) < at_speed else (low, middle)
    return high
