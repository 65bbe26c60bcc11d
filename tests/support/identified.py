"""What the log of the stand-in's sih was flown with, and how near to it a figure is."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from companion.identification.rate_fit import Found


class Machine(NamedTuple):
    """``hover``: thrust, 0..1. ``drag``: 1/s. ``motor_lag``, ``loop_lag``: s. ``authority``: rad/s^2, by axis."""

    hover: float
    drag: float
    motor_lag: float
    loop_lag: float
    authority: tuple[float, float, float]


TRUE = Machine(hover=0.4905, drag=1.0, motor_lag=0.05, loop_lag=0.071, authority=(113.14, 113.14, 13.33))
"""The stand-in's sih; the loop's lag was measured on PX4, which the stand-in is held to."""


def near(value: Found, true: float, within: float = 0.05) -> None:
    assert value.value == pytest.approx(true, rel=within)
    assert abs(value.value - true) < max(5.0 * value.std, 0.03 * true), f"{value} is surer than it is right ({true})"
