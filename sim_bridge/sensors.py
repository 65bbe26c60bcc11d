"""Truth -> the estimate the autopilot flies by and reports.

``observe`` is a pure function of the truth, what the estimator remembers and a source of chance. In a world without
errors the estimate is the truth.
"""

from __future__ import annotations

import random
from typing import NamedTuple

from companion.frames import Quaternion, Vec3
from sim_bridge.plant import Truth

RESETS_OF_A_BOOT = 11
"""What the reset counter stands at when an estimator has come up; PX4's stays there in flight."""


class Estimate(NamedTuple):
    """The vehicle's idea of its state. ``time_us``: the vehicle's clock; ``a_n`` m/s^2; ``resets``: 0..255."""

    time_us: int
    p_n: Vec3
    v_n: Vec3
    a_n: Vec3
    q_nb: Quaternion
    w_b: Vec3
    resets: int


class Memory(NamedTuple):
    """What the estimator carries from one step to the next."""

    resets: int = RESETS_OF_A_BOOT


def observe(truth: Truth, memory: Memory, rng: random.Random) -> tuple[Estimate, Memory]:
    """The estimate after a step, and what to remember for the next."""
    time_us = round(truth.t_boot * 1e6)
    estimate = Estimate(time_us, truth.p_n, truth.v_n, truth.a_n, truth.q_nb, truth.w_b, memory.resets)
    return estimate, memory
