"""The pilot's sticks: MANUAL_CONTROL as PX4 takes it, whether somebody holds them, and whether they have just moved.

Deflections are -1..1: roll right, pitch forward (nose down), yaw right and throttle up are positive.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Value, message
from sim_bridge.autopilot.parameters import Parameters

MANUAL_CONTROL = message("MANUAL_CONTROL")
LOSS_NOTICED_AFTER = 0.06
"""s beyond twice COM_RC_LOSS_T until the loss is noticed: two of PX4's modules wait that long one after the other, and
the second looks ten times a second (seen: 0.05 to 0.07)."""
BY_MAVLINK = frozenset({1, 2, 3, 5, 6, 7, 8})
"""COM_RC_IN_MODE: those that take a joystick."""
SMOOTHING = 0.05
"""s, time constant of the sticks' speed."""
SAME_WAY = 3
"""Samples in a row a stick must move the same way to count as moved."""
CENTRE = 500
"""MANUAL_CONTROL's throttle with the stick in the middle."""


class ManualControlSetpoint(NamedTuple):
    """Where the sticks are, -1..1."""

    roll: float
    pitch: float
    yaw: float
    throttle: float


CENTRED = ManualControlSetpoint(0.0, 0.0, 0.0, 0.0)
"""Sticks that nobody moves."""


class _Speed:
    """How fast one stick moves, smoothed, and for how many samples the same way."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self._last: float | None = None
        self._sign = self._same = 0
        self._value = 0.0

    def update(self, value: float, dt: float, most: float) -> bool:
        """Whether the stick moves faster than ``most`` (1/s)."""
        if dt <= 0.0:
            return False
        if self._last is not None:
            speed = (value - self._last) / dt
            self._value += dt / (SMOOTHING + dt) * (speed - self._value)
            sign = (speed > 0.0) - (speed < 0.0)
            if sign:
                self._same = self._same + 1 if sign == self._sign else 1
                self._sign = sign
        self._last = value
        return abs(self._value) > most and self._same >= SAME_WAY


class ManualControl:
    """``position``: where they are. The source that speaks first is listened to until it falls silent."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.position = CENTRED
        self._at = -math.inf
        self._source: object = None
        self._speeds = tuple(_Speed() for _ in range(4))
        self._moved = False

    def is_lost(self, t: float) -> bool:
        """Whether nobody holds them at ``t`` (s)."""
        return t - self._at > 2.0 * self._parameters["COM_RC_LOSS_T"] + LOSS_NOTICED_AFTER

    def take(self, position: ManualControlSetpoint, source: object, t: float) -> None:
        """A sample."""
        if int(self._parameters["COM_RC_IN_MODE"]) not in BY_MAVLINK:
            return
        age = t - self._at
        silent = age > self._parameters["COM_RC_LOSS_T"]
        if source != self._source and not silent:
            return
        if silent:
            for speed in self._speeds:
                speed.reset()
        self._source, self._at, self.position = source, t, position
        most = self._parameters["MAN_OVERRIDE_SPD"]
        moves = [speed.update(x, min(age, 1.0), most) for speed, x in zip(self._speeds, position, strict=True)]
        if most >= 0.0 and any(moves):
            self._moved = True

    def have_moved(self) -> bool:
        """Whether the pilot has moved them, quickly and with intent, since this was last asked."""
        moved, self._moved = self._moved, False
        return moved


def deflection(frame: Frame, system: int) -> ManualControlSetpoint | None:
    """What a MANUAL_CONTROL says; None: it is for another. A number out of range counts as centred."""
    said = frame.format.named(frame.values)
    pitch, roll, throttle, yaw, target = (said[name] for name in ("x", "y", "z", "r", "target"))
    if target not in (0, system):
        return None
    up = throttle / CENTRE - 1.0 if 0 <= throttle <= 2 * CENTRE else 0.0
    return ManualControlSetpoint(_share(roll), _share(pitch), _share(yaw), up)


def _share(value: Value) -> float:
    return float(value) / 1000.0 if -1000 <= value <= 1000 else 0.0
