"""The damping of the body's turning, found in flight: J w' = tau - w x J w + J (trim - damping w), by axis.

A frame that turns feels the air: a rotor that moves up gives less, one that moves down more. The observer's trim
follows that too, but late: on a circle flown at a fixed heading the body rates turn once a lap, and by the observer's
lag at 1.4 rad/s nearly half of the damping would be left in the motion (circle of 5 m at 7 m/s: 3 % too fast).

What the trim shows is F(trim_0 - damping w), F being the observer's own lag; so the slope of the trim over F(w) is the
damping. It is taken over the last AVERAGING_TIME, from exponentially weighted means; in a hover there is nothing to
see, and EXCITATION keeps it at zero.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.frames import Vec3, clamped

AVERAGING_TIME = 6.0
"""s over which the means are taken. Engineering choice: about a lap of a small circle."""
EXCITATION = 0.05**2
"""(rad/s)^2 added to the variance of the body rates (ridge regression): noise of the gyro is no turning. Engineering
choice: a twentieth of what a circle of 5 m at 3 m/s has."""
DAMPING_MAX = 6.0
"""1/s. Engineering choice: rotors of an x500, at an induced velocity of 5 m/s, damp its rolling by about 4 1/s."""


class AxisRegression(NamedTuple):
    """One axis. ``near``, ``lagged``: rad/s, the body rate through the first lag of the observer and through both.
    ``rate``: rad/s and ``turning``: rad/s^2, means of ``lagged`` and of what turns the body beside its motors;
    ``variance``: (rad/s)^2; ``covariance``: rad^2/s^3."""

    near: float = 0.0
    lagged: float = 0.0
    rate: float = 0.0
    turning: float = 0.0
    variance: float = 0.0
    covariance: float = 0.0

    @property
    def damping(self) -> float:
        """1/s."""
        return clamped(-self.covariance / (self.variance + EXCITATION), 0.0, DAMPING_MAX)


Regressions = tuple[AxisRegression, AxisRegression, AxisRegression]
"""Of the three body axes."""
NO_TURNING: Regressions = (AxisRegression(), AxisRegression(), AxisRegression())
"""Before a flight."""


def update_regressions(
    regressions: Regressions, w_b: Vec3, trim: Vec3, damping: Vec3, pole: float, dt: float
) -> Regressions:
    """``regressions`` ``dt`` s later. ``w_b``: rad/s. ``trim``: rad/s^2, what the observer finds beside ``damping``
    (1/s). ``pole``: 1/s, of the observer, which has it twice."""
    k, slow = min(1.0, pole * dt), min(1.0, dt / AVERAGING_TIME)
    x, y, z = regressions
    return (
        _update_axis(x, w_b[0], trim[0], damping[0], k, slow),
        _update_axis(y, w_b[1], trim[1], damping[1], k, slow),
        _update_axis(z, w_b[2], trim[2], damping[2], k, slow),
    )


def damping_of(regressions: Regressions) -> Vec3:
    """1/s, about the body axes."""
    x, y, z = regressions
    return (x.damping, y.damping, z.damping)


def _update_axis(axis: AxisRegression, w: float, trim: float, damping: float, k: float, slow: float) -> AxisRegression:
    near, lagged, rate, turning, variance, covariance = axis
    near += k * (w - near)
    lagged += k * (near - lagged)
    off = lagged - rate
    beside = trim - damping * lagged - turning
    keep = 1.0 - slow
    return AxisRegression(
        near,
        lagged,
        rate + slow * off,
        turning + slow * beside,
        keep * (variance + slow * off * off),
        keep * (covariance + slow * off * beside),
    )
