"""Path poles: chosen by the noise when a path is begun, then only lowered, and slowly; written ones stay."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from companion.law.gains import Level, auto_gains, mean_pole, with_path_poles
from companion.steering.assembly import pole_choice
from companion.steering.path_poles import (
    AS_WRITTEN,
    KNOWN_AFTER,
    LOWERING_TIME,
    ROUGHNESS_MOST,
    TILT_PER_POLE,
    TILT_TIME,
    PathPoles,
    update_path_poles,
)
from companion.steering.speed_governor import Course, Place
from trials.measured import machine

DT = 0.008
AUTO = pole_choice(-6.0, machine("sih"))


def flown(
    poles: PathPoles, noise: float, seconds: float, along: bool, choice=AUTO, bend: float = 0.0, tilt: float = 0.4
) -> list[PathPoles]:  # type: ignore[no-untyped-def]
    """The poles after every command. ``noise``: rad/s of roll and pitch rate; ``bend``: rad/s, of a sine at 3 rad/s.
    ``tilt``: rad."""
    rng, found = random.Random(1), []
    for k in range(round(seconds / DT)):
        turn = bend * math.sin(3.0 * k * DT)
        rates = (turn + rng.gauss(0.0, noise), -turn + rng.gauss(0.0, noise), 0.0)
        poles = update_path_poles(poles, choice, rates, tilt, DT, along=along)
        found.append(poles)
    return found


def test_in_quiet_the_fastest_are_kept_however_it_turns() -> None:
    hold = flown(PathPoles(), 0.0005, 3.0, along=False)[-1]
    assert all(poles.scale == 1.0 for poles in flown(hold, 0.0005, 10.0, along=True, bend=2.0))


@pytest.mark.parametrize("times", [2.0, 3.0])
def test_noise_before_the_path_chooses_slower_ones(times: float) -> None:
    """The hold's poles are at -5: at -6 its noise would be 1.44 times as large."""
    hold = flown(PathPoles(), times * ROUGHNESS_MOST, 4.0, along=False)[-1]
    assert hold.scale == 1.0
    begun = update_path_poles(hold, AUTO, (0.0, 0.0, 0.0), 0.0, DT, along=True)
    assert begun.begun and begun.scale == pytest.approx(max(5.0 / 6.0 / math.sqrt(times), 4.0 / 6.0), rel=0.06)


@pytest.mark.parametrize("jump", [0.5, 5.0])
def test_jumps_before_the_path_are_no_noise(jump: float) -> None:
    """Taking over shakes for 0.15 s, and half a second later the estimate is reset; the rest is quiet."""
    poles, rates = flown(PathPoles(), 0.25, 0.15, along=False)[-1], (0.0, 0.0, 0.0)
    for k in range(round(1.5 / DT)):
        rates = (jump, -jump, 0.0) if k > 60 else (0.0, 0.0, 0.0)
        poles = update_path_poles(poles, AUTO, rates, 0.0, DT, along=False)
    assert poles.known > KNOWN_AFTER
    assert update_path_poles(poles, AUTO, rates, 0.0, DT, along=True).scale == 1.0


def test_on_the_path_they_are_only_lowered_and_take_their_time() -> None:
    start = update_path_poles(
        flown(PathPoles(), 0.0005, 2.0, along=False)[-1], AUTO, (0.0, 0.0, 0.0), 0.0, DT, along=True
    )
    loud = flown(start, 4.0 * ROUGHNESS_MOST, 12.0, along=True)
    steps = np.diff([poles.scale for poles in loud])
    assert steps.max() <= 0.0 and steps.min() >= -DT / LOWERING_TIME - 1e-12
    assert loud[-1].scale == pytest.approx(4.0 / 6.0)  # no slower than any that is chosen
    assert flown(loud[-1], 0.0, 10.0, along=True)[-1].scale == loud[-1].scale
    assert flown(loud[-1], 0.0, 2.0, along=False)[-1].scale == loud[-1].scale


@pytest.mark.parametrize(("room", "pole"), [(30.0, 7.5), (8.5, 8.5 / 1.18), (6.0, 8.0 / 1.18), (-5.0, 8.0 / 1.18)])
def test_where_the_vehicle_leans_steeply_they_are_slower(room: float, pole: float) -> None:
    """At most the room to the failure detector over 1.18 deg; the speed governor leaves 8 deg of it."""
    assert math.degrees(TILT_PER_POLE) == pytest.approx(1.18)
    quick = pole_choice(-7.5, machine("sih"))
    steep = flown(
        PathPoles(begun=True), 0.0, 12.0 * TILT_TIME, along=True, choice=quick, tilt=math.radians(60.0 - room)
    )
    assert 7.5 * steep[-1].scale == pytest.approx(pole, rel=5e-3)
    assert min(np.diff([poles.scale for poles in steep])) >= -DT / LOWERING_TIME - 1e-9
    after = flown(steep[-1], 0.0, 20.0, along=True, choice=quick, tilt=0.1)[-1]
    assert after.scale == steep[-1].scale


@pytest.mark.parametrize(("across", "scale"), [(1.8, 1.0), (9.8, 8.0 / 1.18 / 7.5), (30.0, 8.0 / 1.18 / 7.5)])
def test_a_path_that_is_steep_begins_with_slower_ones(across: float, scale: float) -> None:
    """9.8 m/s^2 across and 7 of drag: 51 deg."""
    place = Place((1.0, 0.0, 0.0), (0.0, across / 49.0, 0.0), 7.0)
    choice = pole_choice(-7.5, machine("sih"), Course((place,), 0.4, True, 1.0))
    assert choice.most == pytest.approx(scale, rel=0.01)
    begun = update_path_poles(PathPoles(), choice, (0.0, 0.0, 0.0), 0.0, DT, along=True)
    assert begun.scale == choice.most


def test_a_steep_bend_that_is_short_changes_nothing() -> None:
    poles = flown(PathPoles(begun=True), 0.0, 20.0, along=True, tilt=math.radians(35.0))[-1]
    assert flown(poles, 0.0, 0.5, along=True, tilt=math.radians(52.0))[-1].scale == 1.0


def test_written_poles_and_a_hold_that_was_short_change_nothing() -> None:
    assert flown(PathPoles(), 1.0, 5.0, along=True, choice=AS_WRITTEN)[-1] == PathPoles()
    short = flown(PathPoles(), 4.0 * ROUGHNESS_MOST, 0.9 * KNOWN_AFTER, along=False)[-1]
    assert update_path_poles(short, AUTO, (0.0, 0.0, 0.0), 0.0, DT, along=True).scale == 1.0


def test_scaled_gains_are_those_of_scaled_poles() -> None:
    gains = auto_gains(Level.RATES, 0.1, 0.08)
    slower = with_path_poles(gains, 0.75)
    assert mean_pole(slower.h1) == pytest.approx(-4.5)
    assert gains.vertical is not None and slower.vertical is not None
    assert mean_pole(slower.vertical) == pytest.approx(-0.75 * 7.5)
    assert (slower.h3, slower.h4) == (gains.h3, gains.h4)
    assert with_path_poles(gains, 1.0) == gains
