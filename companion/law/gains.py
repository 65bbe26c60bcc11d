"""Gains of the linear error dynamics (Eq. 9): h_i^(r_i) = -k_0 h_i - ... - k_{r_i-1} h_i^(r_i-1)."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.calculus.scalar import Scalar
from companion.vehicle import OutputLevel


class Level(enum.Enum):
    """Where the chain of integrators ends: at motor torques (the paper's) or at body rates (one order earlier).

    The value is the relative degree of h1 and h2.
    """

    MOTORS = 4
    RATES = 3

    @property
    def degrees(self) -> tuple[int, int, int, int]:
        """The vector relative degree {r1, r2, r3, r4} (Lemma 4.1): {4, 4, 3, 2} or {3, 3, 2, 1}."""
        n = self.value
        return (n, n, n - 1, n - 2)


def law_level(level: OutputLevel) -> Level:
    """The level of the law that an output level needs: attitude is rates, and torques are motors, sent another way."""
    return Level.MOTORS if level.without_rate_loop else Level.RATES


@dataclass(frozen=True, slots=True)
class Gains:
    """One tuple per output, ``[0]`` on the output itself, as many as its relative degree."""

    h1: tuple[float, ...]
    h2: tuple[float, ...]
    h3: tuple[float, ...]
    h4: tuple[float, ...]

    @property
    def each(self) -> tuple[tuple[float, ...], ...]:
        """(h1, h2, h3, h4)."""
        return (self.h1, self.h2, self.h3, self.h4)


def from_poles(poles: Sequence[complex]) -> tuple[float, ...]:
    """k_0 .. k_{n-1} of the monic polynomial with these roots: (s - p_1)...(s - p_n); complex ones in conjugate pairs,
    whose imaginary parts cancel."""
    coefficients: list[complex] = [1.0]
    for pole in poles:
        longer = [*coefficients, 0.0]
        for i, c in enumerate(coefficients):
            longer[i + 1] -= pole * c
        coefficients = longer
    return tuple(complex(k).real for k in reversed(coefficients[1:]))


def with_path_poles(gains: Gains, scale: Scalar) -> Gains:
    """``gains`` with the poles of h1 and h2 times ``scale``: k_i scale^(n - i). A number, or the symbol of a tape."""

    def scaled(ks: tuple[float, ...]) -> tuple[float, ...]:
        factors = [scale]
        for _ in ks[1:]:
            factors.append(factors[-1] * scale)
        return tuple(k * factor for k, factor in zip(ks, reversed(factors), strict=True))

    return Gains(scaled(gains.h1), scaled(gains.h2), gains.h3, gains.h4)


def poles_of(gains: Sequence[float]) -> list[complex]:
    """The roots of s^n + k_{n-1} s^(n-1) + ... + k_0."""
    return [complex(root) for root in np.roots([1.0, *reversed(gains)])]


PATH_POLES = {Level.MOTORS: (-5.0,) * 4, Level.RATES: (-5.0,) * 3}
"""1/s, of h1 and h2 where a mission gives no gains. Flights on PX4's simulated quadrotor at -3 to -10: fast enough to
stay linear, at most 0.4 of the pole at which the delays make it unstable."""
SPEED_POLES = {Level.MOTORS: (-3.0,) * 3, Level.RATES: (-2.5,) * 2}
"""1/s, of h3. Simulated in the same flights: -1.5 to -4 make no difference to the path."""
YAW_POLES = {Level.MOTORS: (-2.0,) * 2, Level.RATES: (-2.25,)}
"""1/s, of h4. Engineering choice: slower than PX4's yaw loop (MC_YAW_P 2.8)."""


AUTO_POLE_TIME = 0.5
"""rad: path poles chosen for a flight times the horizon of the prediction. Engineering choice: a triple pole at -L
crosses over at 3 L, and of a horizon a third is counted on to be wrong: 3 L h / 3 = 0.5 rad of phase lost, of about
60 deg that a triple pole has."""
AUTO_POLE_RANGE = (4.0, 6.0)
"""1/s. Simulated on sih_noisy, 40 s at 3 m/s: -5 2.8 cm, -6 2.4, -7 2.1, -8 1.9; heading 0.7, 0.9, 1.2, 2.0 deg;
commands shake by 2.2, 3.1, 4.0, 5.2 deg/s. -6 is where the heading is still held to a degree."""


BODY_POLE_TIME = 0.8
"""Ratio: the fourth pole at motors, which stands for the vehicle's rate loop, times the horizon of the prediction.
On PX4's simulated quadrotor (motor lag 50 ms) that is its rate loop's own lag: -14."""
BODY_POLE_RANGE = (6.0, 14.0)
"""1/s. Flown on sih_noisy, 40 s at 3 m/s, path poles -6: -14 2.8 cm, -20 2.7; with four at -5 4.1 cm. At 14
states a second the loop is stable with -14, and hardly with -20."""


def auto_gains(level: Level, horizon: float) -> Gains:
    """The gains chosen for a flight whose mission writes none. ``horizon``: s, dead time and lag of the rate loop, or
    of the motors.

    The estimate's wander and what is unknown of the forces put an error of 3 / L^2 times their acceleration beside the
    path, so poles are as fast as the horizon allows; noise puts L times itself into the commands. At motors the same
    poles stand beside a fourth, that of the turning body: four equal ones would have to be at -7 for the same error.
    """
    usual = default_gains(level)
    least, most = AUTO_POLE_RANGE
    pole = -min(max(AUTO_POLE_TIME / horizon, least), most)
    if level is Level.RATES:
        path = from_poles((pole,) * 3)
        return Gains(path, path, usual.h3, usual.h4)
    least, most = BODY_POLE_RANGE
    body = -min(max(BODY_POLE_TIME / horizon, least), most)
    path = from_poles((pole, pole, pole, body))
    return Gains(path, path, from_poles((*SPEED_POLES[level][:2], body)), usual.h4)


def default_gains(level: Level) -> Gains:
    """The gains of ``level`` for a mission that gives none."""
    path = from_poles(PATH_POLES[level])
    return Gains(path, path, from_poles(SPEED_POLES[level]), from_poles(YAW_POLES[level]))
