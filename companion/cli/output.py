"""The choices of the command line, in a file that is read at once."""

from __future__ import annotations

import enum

from companion.library.output import Output

__all__ = ["Ends", "LawOutput", "Output", "WhoStarts"]


class LawOutput(enum.Enum):
    """``law --output``."""

    MOTORS = "motors"
    RATES = "rates"


class WhoStarts(enum.Enum):
    """``--start``."""

    COMPANION = "companion"
    PILOT = "pilot"
    MODE = "mode"


class Ends(enum.Enum):
    """``--finish``."""

    HOLD = "hold"
    LAND = "land"
    RETURN = "return"
