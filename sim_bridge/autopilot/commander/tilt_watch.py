"""Whether the vehicle has tipped over: PX4's failure detector of attitude."""

from __future__ import annotations

import math

from companion.frames import Quaternion, euler_from_rotation, rotation_matrix
from sim_bridge.autopilot.parameters import Parameters


class TiltWatch:
    """Roll or pitch beyond FD_FAIL_R, FD_FAIL_P (degrees) for FD_FAIL_*_TTRI s."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._since: dict[str, float] = {}

    def update(self, t: float, q_nb: Quaternion, attitude_is_controlled: bool) -> bool:
        """The verdict at ``t`` (s). Who flies rates may do what he likes."""
        if not attitude_is_controlled:
            self._since.clear()
            return False
        _, pitch, roll = euler_from_rotation(rotation_matrix(q_nb))
        return any([self._beyond("R", roll, t), self._beyond("P", pitch, t)])

    def _beyond(self, axis: str, angle: float, t: float) -> bool:
        limit = self._parameters[f"FD_FAIL_{axis}"]
        if limit <= 0.0 or abs(math.degrees(angle)) <= limit:
            self._since.pop(axis, None)
            return False
        return t - self._since.setdefault(axis, t) >= self._parameters[f"FD_FAIL_{axis}_TTRI"]
