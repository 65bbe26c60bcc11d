"""PX4's flight modes and landed states as they stand on the wire.

``custom_mode`` is ``main << 16 | sub << 24`` in HEARTBEAT, CURRENT_MODE and the parameters of DO_SET_MODE.
"""

from __future__ import annotations

import enum


class Mode(enum.Enum):
    """A flight mode: (main, sub)."""

    MANUAL = (1, 0)
    ALTITUDE = (2, 0)
    POSITION = (3, 0)
    ORBIT = (3, 1)
    POSITION_SLOW = (3, 2)
    READY = (4, 1)
    TAKEOFF = (4, 2)
    HOLD = (4, 3)
    MISSION = (4, 4)
    RETURN = (4, 5)
    LAND = (4, 6)
    FOLLOW = (4, 8)
    PRECISION_LAND = (4, 9)
    GUIDED_COURSE = (4, 19)
    DESCEND = (4, 20)
    ACRO = (5, 0)
    OFFBOARD = (6, 0)
    STABILIZED = (7, 0)
    TERMINATION = (10, 0)
    ALTITUDE_CRUISE = (11, 0)
    UNKNOWN = (0, 0)

    @property
    def main(self) -> int:
        """The main mode of DO_SET_MODE's second parameter."""
        return self.value[0]

    @property
    def sub(self) -> int:
        """The sub mode of DO_SET_MODE's third parameter."""
        return self.value[1]

    @property
    def custom_mode(self) -> int:
        """The number in HEARTBEAT and CURRENT_MODE."""
        return self.value[0] << 16 | self.value[1] << 24


_BY_CUSTOM_MODE = {mode.custom_mode: mode for mode in Mode}


def mode_of(custom_mode: int) -> Mode:
    """The mode of a ``custom_mode``; UNKNOWN for one this table does not have."""
    return _BY_CUSTOM_MODE.get(custom_mode, Mode.UNKNOWN)


class Landed(enum.Enum):
    """MAV_LANDED_STATE of EXTENDED_SYS_STATE."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4
