"""Path poles by the noise and the tilt found: chosen when the path is begun, and after that only lowered.

    commands of a law with poles at -L carry noise in proportion to L^2

(the gain on the velocity, 3 L^2 / g, is what its noise comes through). So where the commands of the hold before the
path are rough by n, with poles at -L_h, those that keep the roughness at ROUGHNESS_MOST are L_h sqrt(ROUGHNESS_MOST /
n). Poles that a mission writes stay as written.

Noise is told from motion by the second differences of what is commanded, 8 ms apart: there a bend is next to nothing
beside noise that is new at every state. It is told from jumps, those of taking over and of an estimate that is reset,
by their mean size, not their square, each counted no larger than JUMP.

Noise shakes the tilt too, in proportion to L. Where the vehicle leans steeply, by its path or in wind, the room up to
its failure detector is all there is for that: poles are at most that room over TILT_PER_POLE.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.frames import Vec3
from companion.steering.tilt_barrier import STEADY_UNDER_DETECTOR

ROUGHNESS_MOST = math.radians(3.5)
"""rad/s, of roll and pitch rate commanded (at motors those that the law heads for): their noise, by second differences
over sqrt(6). Simulated on sih_noisy: with the poles that are chosen it is 1.5 deg/s at 3 m/s and 2.2 at 7, and slower
poles cost more of the path (3.2 cm at -4) than the noise is worth; twice that comes to this."""
JUMP = 3.0 * ROUGHNESS_MOST
"""rad/s: a larger one is counted as this large. Simulated on sih_noisy: taking over jumps by up to 60 deg/s and a reset
by 50, between which commands are rough by 1 deg/s; squared, they slowed the poles of every fifth flight."""
MEAN_SIZE = 0.5 * math.sqrt(math.pi)
"""Ratio of the mean size of two normal numbers, sqrt((p^2 + q^2) / 2), to their standard deviation. By definition."""
ROUGHNESS_TIME = 2.0
"""s over which it is averaged. Engineering choice."""
KNOWN_AFTER = 1.0
"""s of commands before the path after which the roughness is believed. Engineering choice."""
LOWERING_TIME = 5.0
"""s in which poles are lowered from 1 to nothing at the soonest. Engineering choice."""
TILT_PER_POLE = math.radians(1.18)
"""rad s: room for the tilt per 1/s of the poles. Simulated on sih_noisy, circle r5 at 7 m/s (a steady 51 deg): the tilt
shakes by 2.2 deg at -6 and by 2.6 at -7.5; -7.5 was handed back in still air and in wind, -6.8 in none of five flights
and in no wind of four."""
TILT_BEYOND = math.radians(1.2)
"""rad by which a mean over TILT_TIME is beyond the steady tilt of a path. Simulated: circle r5, 7 m/s, sih_noisy."""
TILT_TIME = 1.0
"""s over which the tilt is averaged. Engineering choice: so long does a vehicle lean where a circle meets the wind."""
STEP_MAX = 0.03
"""s between two commands beyond which their differences are motion too. Engineering choice."""
SECOND_DIFFERENCE = 6.0
"""Ratio of the variance of the second difference of white noise to its own: 1 + 4 + 1. By definition."""


class PathPoles(NamedTuple):
    """``scale``: on the poles that the law was recorded with. ``begun``: whether a path is flown: from then on they are
    only lowered. ``roughness``: rad/s, mean over ROUGHNESS_TIME. ``known``: s of commands in it. ``last``,
    ``before``: rad/s, the last two commands. ``tilt``: rad, mean over TILT_TIME along a path."""

    scale: float = 1.0
    begun: bool = False
    roughness: float = 0.0
    known: float = 0.0
    last: Vec3 | None = None
    before: Vec3 | None = None
    tilt: float = 0.0


class PoleChoice(NamedTuple):
    """``least``: the least scale; 1 where poles are written, which are flown as they are. ``hold_scale``: the poles of
    the hold before a path over those of the path. ``most``: the largest scale, by the tilt of the path in still air.
    ``pole``: 1/s, of the path, its size. ``steepest``: rad, the tilt at which the vehicle's failure detector ends a
    flight."""

    least: float = 1.0
    hold_scale: float = 1.0
    most: float = 1.0
    pole: float = 0.0
    steepest: float = math.inf


AS_WRITTEN = PoleChoice()


def update_path_poles(
    poles: PathPoles, choice: PoleChoice, rates_b: Vec3, tilt: float, dt: float, *, along: bool
) -> PathPoles:
    """``poles`` after another command (rad/s), ``dt`` s after the last. ``tilt``: rad. ``along``: it flies a path."""
    if choice.least >= 1.0:
        return poles
    if along and not poles.begun:
        scale = choice.most
        if poles.known > KNOWN_AFTER:
            scale = min(max(choice.hold_scale * _ratio(poles), choice.least), scale)
        return PathPoles(scale, True, last=rates_b)  # what the hold's poles made of the noise is not theirs
    if not along:
        return _observe(poles, rates_b, poles.tilt, dt)
    poles = _observe(poles, rates_b, poles.tilt + min(dt / TILT_TIME, 1.0) * (tilt - poles.tilt), dt)
    wanted = steep_scale(poles.tilt, choice.pole, choice.steepest)
    if poles.known >= ROUGHNESS_TIME:
        wanted = min(wanted, poles.scale * _ratio(poles))
    wanted = max(wanted, choice.least)
    return poles if wanted >= poles.scale else poles._replace(scale=max(wanted, poles.scale - dt / LOWERING_TIME))


def steep_scale(tilt: float, pole: float, steepest: float) -> float:
    """The scale that the room from a tilt to the steepest (rad) leaves to a pole (1/s): STEADY_UNDER_DETECTOR at least,
    which the speed governor keeps."""
    return min(max(steepest - tilt, STEADY_UNDER_DETECTOR) / (TILT_PER_POLE * pole), 1.0)


def _ratio(poles: PathPoles) -> float:
    """What the poles must be multiplied with to be as rough as may be."""
    return math.sqrt(ROUGHNESS_MOST / max(poles.roughness, 1e-9))


def _observe(poles: PathPoles, rates_b: Vec3, tilt: float, dt: float) -> PathPoles:
    """``poles`` with the roughness of another command. ``tilt``: rad, the mean with this one's."""
    last, before = poles.last, poles.before
    if last is None or before is None or not 0.0 < dt < STEP_MAX:
        return poles._replace(last=rates_b, before=last, tilt=tilt)
    p, q = rates_b[0] - 2.0 * last[0] + before[0], rates_b[1] - 2.0 * last[1] + before[1]
    size = min(math.sqrt(0.5 * (p * p + q * q) / SECOND_DIFFERENCE), JUMP)
    k = dt / min(ROUGHNESS_TIME, poles.known + dt)
    roughness = poles.roughness + k * (size / MEAN_SIZE - poles.roughness)
    return PathPoles(poles.scale, poles.begun, roughness, poles.known + dt, rates_b, last, tilt)
