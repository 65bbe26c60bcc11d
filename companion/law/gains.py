"""Gains of the linear error dynamics (Eq. 9): h_i^(r_i) = -k_0 h_i - ... - k_{r_i-1} h_i^(r_i-1)."""

from __future__ import annotations

import enum
import math
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
    """One tuple per output, ``[0]`` on the output itself, as many as its relative degree.

    ``vertical``: in the place of those of h1 and h2 for the vertical part of the distance to the path; None: theirs.
    """

    h1: tuple[float, ...]
    h2: tuple[float, ...]
    h3: tuple[float, ...]
    h4: tuple[float, ...]
    vertical: tuple[float, ...] | None = None

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
    """``gains`` with the poles of h1, h2 and the vertical times ``scale``: k_i scale^(n - i). A number, or the symbol
    of a tape."""

    def scaled(ks: tuple[float, ...]) -> tuple[float, ...]:
        factors = [scale]
        for _ in ks[1:]:
            factors.append(factors[-1] * scale)
        return tuple(k * factor for k, factor in zip(ks, reversed(factors), strict=True))

    vertical = None if gains.vertical is None else scaled(gains.vertical)
    return Gains(scaled(gains.h1), scaled(gains.h2), gains.h3, gains.h4, vertical)


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


AUTO_POLE_TIME = {Level.RATES: 0.6, Level.MOTORS: 0.5}
"""rad: path poles chosen for a flight times the horizon of the prediction. Engineering choice: of a horizon a third is
counted on to be wrong. Three poles at rates cross over at 2.7 L, and 2.7 L h / 3 = 0.54 rad of phase are lost (31 deg)
of 69; three equal ones, as at motors beside the fourth, cross over at 3 L and lose 0.5 rad at 0.5."""
AUTO_DAMPING = 0.85
"""Ratio, of the pair of path poles at rates that stands beside -L, as far from zero. bench.noise_floor: for commands of
the same size 3 % nearer to the path than three equal ones. With 0.7 5 %, but where the vehicle leans by 51 deg (circle
r5 at 7 m/s, simulated on sih_noisy) it was handed back in two flights of three; with this in none of eight."""
AUTO_POLE_RANGE = {Level.RATES: (4.0, 7.0), Level.MOTORS: (4.0, 7.0)}
"""1/s. Simulated on sih_noisy, circle r5 at 3 m/s, level part of the distance: -6 1.5 cm, -7 1.3, -8 1.2. At -7.5 a
vehicle whose setpoints come later and later tilts by 53 deg until it is handed back, and by under 45 at -7. Heading:
docs/estimation.md. At motors bench.noise_floor has 2.0 cm with -6, 1.7 with -7 and 1.6 with -8."""
VERTICAL_POLE_MAX = 10.5
"""1/s, of the height. Simulated likewise, vertical part: -6 2.1 cm, -9 1.5, -10 1.3; the thrust commanded changes by
0.2, 0.35 and 0.45 % of its range from state to state."""
VERTICAL_POLE_TIME = 0.6
"""rad: its poles times the time after which the thrust acts. As AUTO_POLE_TIME at rates: at motors its fourth pole
stands for nothing that lags."""
VERTICAL_FOURTH = 2.0
"""Ratio, of the fourth pole of the height at motors to the others: the thrust is integrated once more there.
bench.noise_floor, vertical part: 1.6 cm with the fourth of the level distance, 1.5 with this, 1.3 with six times the
others, which shakes a vehicle that leans by 50 deg."""
VERTICAL_POLE_LEAD = 0.3
"""rad: what its poles may be times the time by which the motors are later than the rate loop, and times that by which
they may be later than told. The thrust is led by the first, and 2.7 L is the gain of that loop. Engineering choice:
0.8, of 1 at which it swings. Simulated: at 1.4 it did on a vehicle said to have no rate loop's lag, and at 0.33 of the
second one on an airframe with motors of 56 ms, told 25, and a thrust curve (seed 20 of bench.airframes)."""
THRUST_HORIZON_MOST = 0.068
"""s: motors of 60 ms, dead time and hold. Engineering choice: nothing finds their lag in flight, so the slowest of
bench.airframes are counted on."""
AUTO_SPEED_POLE = -3.0
"""1/s, of the speed. Simulated at rates likewise: -2.5 2.3 % of the speed, -5 1.9, -6 1.8; path and heading are the
same. Where the state freezes but for its noise, a vehicle tilts by 60 deg with -6 until it is handed back, by 49 with
-4 and by under 45 with -3."""


BODY_POLE_TIME = 0.8
"""Ratio: the fourth pole at motors, which stands for the vehicle's rate loop, times the horizon of the prediction.
On PX4's simulated quadrotor (motor lag 50 ms) that is its rate loop's own lag: -14."""
BODY_POLE_RANGE = (6.0, 14.0)
"""1/s. Flown on sih_noisy, 40 s at 3 m/s, path poles -6: -14 2.8 cm, -20 2.7; with four at -5 4.1 cm. At 14
states a second the loop is stable with -14, and hardly with -20."""
AUTO_YAW_POLE = {Level.RATES: -4.0, Level.MOTORS: -3.0}
"""1/s, of the heading. At rates less where the yaw loop is slow (steering.yaw); simulated on sih_noisy, figure-eight at
3 m/s: -2.25 1.04 deg, -3 0.98, -4 0.95; airframes nobody knows, nose along the path: -3 1.3, -4 1.2. At motors, where
no yaw loop lags, circle r5 at 3 m/s 0.6 deg, with -2 0.9; at 7 m/s, where the motors have no torque left for it half of
the time, 5 and 8."""


def auto_gains(level: Level, horizon: float, thrust_horizon: float | None) -> Gains:
    """The gains chosen for a flight whose mission writes none. ``horizon``: s, dead time and lag of the rate loop, or
    of the motors. ``thrust_horizon``: s, dead time and lag of the motors; None: the height has no poles of its own.

    The estimate's wander and what is unknown of the forces put an error of 3 / L^2 times their acceleration beside the
    path, so poles are as fast as the horizon allows; noise puts L times itself into the commands, and into the tilt.
    The thrust that holds the height waits for no rate loop, and an estimate's height wanders most: its poles are
    faster. At motors the poles stand beside a fourth: that of the turning body, or of the thrust that is integrated.
    """
    vertical = None
    least, most = AUTO_POLE_RANGE[level]
    level_poles = _spread(-min(max(AUTO_POLE_TIME[level] / horizon, least), most))
    if thrust_horizon is not None:
        late = max(thrust_horizon - horizon, THRUST_HORIZON_MOST - thrust_horizon, 1e-6)
        pole = min(VERTICAL_POLE_TIME / thrust_horizon, VERTICAL_POLE_MAX, VERTICAL_POLE_LEAD / late)
        vertical = _spread(-max(pole, least))
    if level is Level.RATES:
        path, speed = from_poles(level_poles), from_poles((AUTO_SPEED_POLE,) * 2)
        yaw = from_poles((AUTO_YAW_POLE[level],))
        return Gains(path, path, speed, yaw, None if vertical is None else from_poles(vertical))
    least, most = BODY_POLE_RANGE
    body = -min(max(BODY_POLE_TIME / horizon, least), most)
    path, speed = from_poles((*level_poles, body)), from_poles((AUTO_SPEED_POLE, AUTO_SPEED_POLE, body))
    own = None if vertical is None else from_poles((*vertical, VERTICAL_FOURTH * vertical[0]))
    return Gains(path, path, speed, from_poles((AUTO_YAW_POLE[level],) * 2), own)


def _spread(pole: float) -> tuple[complex, ...]:
    """A real pole (1/s) and a pair as far from zero."""
    pair = complex(AUTO_DAMPING * pole, math.sqrt(1.0 - AUTO_DAMPING**2) * pole)
    return (pole, pair, pair.conjugate())


def mean_pole(gains: Sequence[float]) -> float:
    """1/s: the geometric mean of the poles."""
    return -math.pow(gains[0], 1.0 / len(gains))


def path_pole_of(gains: Gains) -> float:
    """1/s: the geometric mean of the poles of h1, at motors of all but the fourth, that of the turning body."""
    slowest = sorted(abs(pole) for pole in poles_of(gains.h1))[: Level.RATES.value]
    return -math.pow(math.prod(slowest), 1.0 / len(slowest))


def default_gains(level: Level) -> Gains:
    """The gains of ``level`` for a mission that gives none."""
    path = from_poles(PATH_POLES[level])
    return Gains(path, path, from_poles(SPEED_POLES[level]), from_poles(YAW_POLES[level]))
