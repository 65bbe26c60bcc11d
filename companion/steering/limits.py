"""Limits: body rates and thrust within what the vehicle may be asked for, and the anti-windup that follows from them.

Thrust goes out normalised, hover_thrust at one g. PX4 makes it linear in the force by its own THR_MDL_FAC before it
reaches the motors, and MPC_THR_HOVER counts in the same units. What that leaves of a curve is found in flight
(``estimation.thrust_curve``) and inverted here: on this side of the encoding thrust is linear in the command.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.estimation.thrust_curve import PROPORTIONAL, ThrustCurve
from companion.frames import Matrix3, Vec3, clamped, upright_error
from companion.law.errors import LawError
from companion.thrust_range import Bound, ThrustRange
from companion.vehicle import GRAVITY, Limits

TILT_RATE_MAX = 4.0
"""rad/s of roll and pitch rate. PX4's default MC_ROLLRATE_MAX is 3.8."""
THRUST_MIN = 0.05
"""Normalised, the least that is sent. Engineering choice: motors that never stop."""
THRUST_MAX = 0.97
"""Normalised, the most that is sent. Engineering choice: a little is left for the vehicle's own rate loop."""
THRUST_NEAR_SATURATION = 0.9
"""Normalised thrust above which single motors meet their limits and nothing is learned. Engineering choice."""
LEVEL_GAIN = 3.0
"""1/s, from the tilt to the rate that levels. Engineering choice: half of PX4's MC_ROLL_P."""
LEVEL_RATE_MAX = 2.0
"""rad/s of it. Engineering choice: half of PX4's MC_ROLLRATE_MAX."""


class LimitedRates(NamedTuple):
    """rad/s. ``sent``: what goes out; ``meant``: what the vehicle makes of it. ``saturated``: roll or pitch was."""

    sent: Vec3
    meant: Vec3
    saturated: bool


class LimitedThrust(NamedTuple):
    """``zeta``: N, the extension after this step; ``zeta_dot``: N/s. ``sent``: normalised; ``specific``: m/s^2, the
    same as commanded thrust over mass; ``newtons``: N, as the vehicle makes it. ``saturated``: the thrust is on a
    bound; ``slew_limited``: zeta_dot is, and what is sent is made all the same."""

    zeta: float
    zeta_dot: float
    sent: float
    specific: float
    newtons: float
    saturated: bool
    slew_limited: bool


def limit_rates(turn: Vec3, gains: tuple[float, float], limits: Limits | None) -> LimitedRates:
    """``turn`` (rad/s) within the vehicle's limits. ``gains``: of its roll and pitch rate loops, by which less is sent
    than is meant. LawError: a rate that is no number, which no clamp would catch."""
    if not math.isfinite(sum(turn)):
        raise LawError(f"the body rates are not finite: {turn}")
    g, k = gains
    p, q, r = turn[0] / g, turn[1] / k, turn[2]
    if limits is None:
        return LimitedRates((p, q, r), (p * g, q * k, r), False)
    p_most, q_most, r_most = limits.body_rates
    p_most, q_most = min(p_most, TILT_RATE_MAX), min(q_most, TILT_RATE_MAX)
    p_sent, q_sent, r_sent = clamped(p, -p_most, p_most), clamped(q, -q_most, q_most), clamped(r, -r_most, r_most)
    return LimitedRates((p_sent, q_sent, r_sent), (p_sent * g, q_sent * k, r_sent), (p_sent, q_sent) != (p, q))


class ThrustConversion(NamedTuple):
    """From a thrust in N to what is sent. ``mass``: kg. ``scale``: thrust made over thrust commanded. ``per_specific``:
    s^2/m, normalised thrust over commanded thrust over mass (hover thrust over gravity). ``curve``: what is made of a
    command that is not proportional to it, at ``gravity`` (m/s^2)."""

    mass: float
    scale: float
    per_specific: float
    gravity: float = GRAVITY
    curve: ThrustCurve = PROPORTIONAL

    @property
    def hover(self) -> float:
        """Normalised thrust of a hover. Whatever has failed, it is a number: as told where nothing else is known."""
        found = self.encoded(self.gravity / self.scale)
        return found if math.isfinite(found) else self.gravity * self.per_specific

    def encoded(self, specific: float) -> float:
        """Normalised, for a commanded thrust over mass (m/s^2) that is linear in the lift."""
        return self.curve.command_for(specific, self.gravity) * self.per_specific

    def specific(self, normalised: float) -> float:
        """m/s^2, of the same."""
        return self.curve.made_of(normalised / self.per_specific, self.gravity)


def limit_thrust(
    range_: ThrustRange, zeta: float, zeta_derivative: float, dt: float, most: float, after_horizon: float,
    conversion: ThrustConversion,
) -> LimitedThrust:  # fmt: skip
    """zeta (N) integrated over ``dt`` s within its bounds, and the thrust to send.

    ``zeta_derivative``: N/s, by the law. ``most``: N, what the vehicle has. ``after_horizon``: s, mostly negative, from
    the time of zeta to the middle of the time in which the thrust of this command acts. Anti-windup: on a bound
    zeta_dot is zero. The rates of a vehicle that is restrained are zero, so its zeta settles at what the path asks of
    one at rest with this tilt, and it is not flung away when it is released. LawError: a thrust that is no number; PX4
    from 1.18 on stops the motors at it.
    """
    later, zeta_dot, bound = range_.integrated(zeta, zeta_derivative, dt, min(range_.high, most))
    newtons_per_specific = conversion.mass * conversion.scale
    wanted = conversion.encoded((zeta + zeta_dot * after_horizon) / newtons_per_specific)
    if not math.isfinite(wanted + later):
        raise LawError(f"the thrust is not finite: {wanted}")
    sent = clamp_thrust(wanted)
    specific = conversion.specific(sent)
    saturated = bound is Bound.LEVEL or sent != wanted
    return LimitedThrust(
        later, zeta_dot, sent, specific, specific * newtons_per_specific, saturated, bound is Bound.SLEW
    )


def clamp_thrust(wanted: float) -> float:
    """Normalised thrust within its range."""
    return clamped(wanted, THRUST_MIN, THRUST_MAX)


def levelling_rates(r_nb: Matrix3) -> Vec3:
    """rad/s that level a vehicle, without a yaw rate."""
    error_x, error_y = upright_error(r_nb)
    most = LEVEL_RATE_MAX
    return clamped(LEVEL_GAIN * error_x, -most, most), clamped(LEVEL_GAIN * error_y, -most, most), 0.0
