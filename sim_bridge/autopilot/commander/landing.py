"""Whether the vehicle is on the ground, as PX4 tells it: by what it feels and how far the throttle is open."""

from __future__ import annotations

TAKEOFF_THROTTLE = 0.30
"""Throttle over hover throttle from which a vehicle on the ground counts as taking off."""
CONTACT_TIME = 1.25
"""s of standing on something, while asked to sink, until that is taken for the ground and the throttle is closed."""
LOW_TIME = 0.7
"""s of standing with a low throttle until the vehicle counts as landed."""


class LandDetector:
    """``landed``: the verdict. ``touching``: the ground has been felt for long enough to close the throttle."""

    def __init__(self, landed: bool) -> None:
        self.landed = landed
        self.touching = landed
        self._contact_since: float | None = None
        self._low_since: float | None = None

    def update(self, t: float, contact: bool, throttle: float) -> bool:
        """The verdict at ``t`` (s). ``contact``: legs on the ground; ``throttle``: thrust over hover thrust."""
        low = throttle < TAKEOFF_THROTTLE
        self._contact_since = None if not contact else t if self._contact_since is None else self._contact_since
        self.touching = self._contact_since is not None and t - self._contact_since >= CONTACT_TIME
        self._low_since = None if not (contact and low) else t if self._low_since is None else self._low_since
        if self.landed:
            self.landed = contact and low
        else:
            self.landed = contact and self._low_since is not None and t - self._low_since >= LOW_TIME
        return self.landed
