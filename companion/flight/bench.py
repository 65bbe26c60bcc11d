"""The bench: propellers off, the vehicle is tilted by hand, and what would be commanded must turn it back.

A wrong sign or frame anywhere between the sensor and the setpoint shows here, before anything can fly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

SHOWN_AT = math.radians(10.0)
"""rad of tilt from which the answer counts. Engineering choice."""
TURNING = 0.2
"""rad/s or N m that count as an answer. Engineering choice."""
WRONG_FOR = 25
"""Number of ticks in a row of turning the wrong way before it is called wrong. Engineering choice."""

SIDES = ("roll right", "roll left", "nose up", "nose down")


class Shown(NamedTuple):
    """Which of SIDES were shown right, and how many ticks in a row one was wrong."""

    right: tuple[bool, bool, bool, bool] = (False, False, False, False)
    wrong: int = 0

    @property
    def complete(self) -> bool:
        """Whether all four sides were shown."""
        return all(self.right)


NOTHING_SHOWN = Shown()


def judge_tilt(shown: Shown, roll: float, pitch: float, turn: tuple[float, float, float]) -> tuple[Shown, str | None]:
    """One look: ``roll``, ``pitch`` rad as the vehicle says, ``turn`` as the law asks (its first two components). A
    line for the person at the bench where a side was shown for the first time."""
    right = list(shown.right)
    wrong = 0
    line = None
    for axis, (angle, answer) in enumerate(((roll, turn[0]), (pitch, turn[1]))):
        if abs(angle) < SHOWN_AT or abs(angle) < max(abs(roll), abs(pitch)):
            continue
        side = 2 * axis + (angle < 0.0)
        if answer * angle < 0.0 and abs(answer) > TURNING:
            if not right[side]:
                right[side] = True
                line = f"{SIDES[side]} {math.degrees(abs(angle)):.0f} degrees: the command turns it back"
        elif answer * angle > 0.0:
            wrong = shown.wrong + 1
    a, b, c, d = right
    return Shown((a, b, c, d), wrong), line


def fault(shown: Shown) -> str | None:
    """What is wrong, in words."""
    if shown.wrong < WRONG_FOR:
        return None
    return "the command turns the vehicle further over instead of back; a sign or a frame is wrong, do not fly"


def lacking(shown: Shown) -> str:
    """What is still to be shown."""
    return " and ".join(side for side, right in zip(SIDES, shown.right, strict=True) if not right)
