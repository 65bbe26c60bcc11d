"""`check` and flight: what the one says is what the other does; and what is shipped flies as well as it should.

The whole table, fifty missions, is `bench/agreement.py`.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import companion
from companion.config.syntax.file_lookup import names
from companion.library.calls import Check
from trials.agreement import asked, flown, random_mission, scaled


def settled_after(check: Check, at_least: float = 8.0) -> float:
    """s of following until the start is forgotten: the speed has risen, the errors are gone."""
    return max(at_least, 1.5 + 1.25 * float(np.abs(check.report.at.alpha[0]).max()))


@pytest.mark.parametrize("seed", [2, 12, 28, 34, 44])
def test_check_agrees_with_flight(seed: int) -> None:
    """Thrust, tilt and motors within 3 % of what was predicted; the errors those of the ideal plant."""
    share = 0.55 + 0.4 * ((seed * 0.381966) % 1.0)
    mission, check = scaled(random_mission(seed), share, "x500", "motors")
    did = flown(mission, "x500", "motors", check.report.duration, settled_after(check))
    assert check.feasible
    for name, said, happened in zip(did.extremes._fields, asked(check), did.extremes, strict=True):
        assert happened == pytest.approx(said, rel=0.03), name
    assert did.path_error < 0.01
    assert did.speed_error < 0.02
    assert did.yaw_error < math.radians(1.0)


@pytest.mark.parametrize("seed", range(20, 25))
def test_a_mission_that_is_too_fast_is_refused_with_the_place(seed: int) -> None:
    _, check = scaled(random_mission(seed), 1.02 + 0.05 * (seed % 10), "x500", "motors")
    assert not check.feasible
    assert f"{check.report.tightest.at_s:.1f} m along the path" in check.headline


CLOSED = [n for n in names("missions") if not n.startswith("paper") and companion.load_mission(n).value.closed]
"""The end of an open path is a matter of the flight's phases: tests/flights/test_shipped.py flies one."""


@pytest.mark.parametrize("name", CLOSED)
def test_a_shipped_mission_settles(name: str) -> None:
    """Path error below 1 cm, speed error below 2 % of alpha, yaw error below 1 degree, at motors on the ideal plant."""
    mission = companion.load_mission(name)
    check = companion.check(mission, "x500", output="motors")
    lap = check.report.duration
    did = flown(mission, "x500", "motors", min(lap, 4.0), settled_after(check, 5.0))
    assert did.path_error < 0.01
    assert did.speed_error < 0.02
    assert did.yaw_error < math.radians(1.0)
