"""Which parameters a command takes, and how COMMAND_INT gives a place, as PX4 looks at them before anything else."""

from __future__ import annotations

import math

from sim_bridge.autopilot.commands.parts import NOT_GIVEN
from sim_bridge.autopilot.missions.items import TAKES

COMMANDS_TAKE: dict[int, int] = TAKES | {
    84: 0x7C, 85: 0x7F, 195: 0x71, 224: 0x03, 611: 0x70, 5000: 0x00, 5001: 0x01, 5002: 0x01, 5003: 0x01, 5004: 0x01,
    5100: 0x00,
}  # fmt: skip
"""One bit a parameter. A command that is given another is denied; commands not here take all."""
WITH_A_PLACE = frozenset({21, 22, 23, 34, 35, 80, 84, 179, 187, 189, 192, 195, 201, 611, 30001, 43003})
"""MAV_CMD whose COMMAND_INT carries a place."""
LOCAL_FRAMES = frozenset({1, 4, 7, 8, 9, 12, 20, 21})
"""MAV_FRAME in which x and y are metres times 1e4."""


def stray(command: int, parameters: tuple[float, ...]) -> bool:
    """Whether a parameter is given that the command does not take."""
    takes = COMMANDS_TAKE.get(command)
    if takes is None:
        return False
    return any(not math.isnan(x) and x != 0.0 and not takes >> i & 1 for i, x in enumerate(parameters))


def place_given(command: int, frame: int, x: int, y: int) -> tuple[float, float]:
    """Parameters 5 and 6 of a COMMAND_INT."""
    if x == y == NOT_GIVEN:
        return (math.nan, math.nan)
    if command not in WITH_A_PLACE:
        return (float(x), float(y))
    scale = 1e-4 if frame in LOCAL_FRAMES else 1e-7
    return (x * scale, y * scale)
