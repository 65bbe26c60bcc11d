"""The output levels that may be asked for, in a file that is read at once."""

from __future__ import annotations

import enum


class Output(enum.Enum):
    """``--output``, ``output=``."""

    AUTO = "auto"
    MOTORS = "motors"
    TORQUES = "torques"
    RATES = "rates"
    ATTITUDE = "attitude"
