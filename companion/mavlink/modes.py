"""PX4's flight modes and landed states as they stand on the wire.

``custom_mode`` is ``main << 16 | sub << 24`` in HEARTBEAT, CURRENT_MODE and the parameters of DO_SET_MODE.
"""

from __future__ import annotations

from companion.vehicle import Landed, Mode

__all__ = ["Landed", "Mode", "mode_of"]


_BY_CUSTOM_MODE = {mode.custom_mode: mode for mode in Mode}


def mode_of(custom_mode: int) -> Mode:
    """The mode of a ``custom_mode``; UNKNOWN for one this table does not have."""
    return _BY_CUSTOM_MODE.get(custom_mode, Mode.UNKNOWN)
