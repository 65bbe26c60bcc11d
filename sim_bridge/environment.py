"""What surrounds the vehicle: the ground, and hands that hold it.

The ground is the plane z = 0 of the local frame. A vehicle that comes down on it stops there, without bounce and
without sliding, and rights itself on its legs; it leaves when its rotors lift more than it weighs.
"""

from __future__ import annotations

import math

from companion.frames import Quaternion
from sim_bridge.integrate import Motion

RIGHTING_TIME = 0.1
"""s, how quickly the legs bring a tilted vehicle level."""
LEGS_REACH = 0.5
"""The cosine of the tilt beyond which the legs do not reach the ground: the vehicle lies where it fell."""


def has_touched_down(motion: Motion) -> bool:
    """Whether the body has come down to the ground."""
    return motion[2] >= 0.0 and motion[5] >= 0.0


def cosine_of_tilt(motion: Motion) -> float:
    """The vertical part of the thrust's direction: 1 upright, -1 upside down."""
    return 1.0 - 2.0 * (motion[7] * motion[7] + motion[8] * motion[8])


def at_rest(motion: Motion, step: float) -> Motion:
    """The motion one step later of a vehicle lying on the ground: still, level after RIGHTING_TIME or so."""
    pn, pe, _, _, _, _, w, x, y, z, _, _, _ = motion
    if cosine_of_tilt(motion) > LEGS_REACH and (x != 0.0 or y != 0.0):
        w, x, y, z = _righted((w, x, y, z), step)
    return (pn, pe, 0.0, 0.0, 0.0, 0.0, w, x, y, z, 0.0, 0.0, 0.0)


def held(motion: Motion) -> Motion:
    """The motion of a vehicle that is held fast where it is."""
    return (*motion[0:3], 0.0, 0.0, 0.0, *motion[6:10], 0.0, 0.0, 0.0)


def _righted(q: Quaternion, step: float) -> Quaternion:
    """``q`` with its tilt reduced and its heading kept: every attitude is a heading turn after a tilt without one."""
    w, x, y, z = q
    keep = math.exp(-step / RIGHTING_TIME)
    x, y = (0.0, 0.0) if x * x + y * y < 1e-18 else (x * keep, y * keep)
    unit = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return (w * unit, x * unit, y * unit, z * unit)
