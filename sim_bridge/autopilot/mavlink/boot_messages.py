"""What PX4 says unasked while it boots, and a client must bear: parameters it has just set, and a gripper told to grab.

Names, order and times are those of a recorded session.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.mavlink.dialect import Format, Value, message
from companion.mavlink_common import (
    MAV_CMD_DO_GRIPPER,
)

PARAMETERS_AT_US = 1_120_000
"""us after boot (recorded)."""
PARAMETERS = (
    "CAL_ACC0_ID", "CAL_ACC1_ID", "CAL_ACC2_ID", "CAL_BARO0_ID", "CAL_BARO0_PRIO", "CAL_GYRO0_ID", "CAL_GYRO1_ID",
    "CAL_GYRO2_ID", "CAL_MAG0_ID", "CAL_MAG0_PRIO", "CAL_MAG1_ID", "CAL_MAG1_PRIO", "SENS_BOARD_X_OFF",
    "SENS_DPRES_OFF", "SYS_AUTOCONFIG", "SYS_AUTOSTART",
)  # fmt: skip
GRIPPER_AT_US = (510_000, 1_330_000, 1_830_000, 2_350_000)
"""Nobody answers the first, so it is said again, to everybody, with a confirmation that counts."""
GRAB = 1.0
"""GRIPPER_ACTION_GRAB."""
_COMMAND = message("COMMAND_LONG")


class BootMessages:
    """On one link. ``tell``: a parameter; ``send``: a message."""

    def __init__(self, tell: Callable[[str], None], send: Callable[[Format, tuple[Value, ...]], None]) -> None:
        self._tell, self._send = tell, send
        self._parameters_told = False
        self._grabbed = 0

    def poll(self, now_us: int) -> None:
        """To be called every 10 ms."""
        if not self._parameters_told and now_us >= PARAMETERS_AT_US:
            self._parameters_told = True
            for name in PARAMETERS:
                self._tell(name)
        if self._grabbed < len(GRIPPER_AT_US) and now_us >= GRIPPER_AT_US[self._grabbed]:
            self._send(_COMMAND, _COMMAND.values(command=MAV_CMD_DO_GRIPPER, param2=GRAB, confirmation=self._grabbed))
            self._grabbed += 1
