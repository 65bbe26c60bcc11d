"""The health report: in which modes the vehicle could be armed and flown now, and what stands in the way.

PX4 says it in events alone. A report is a summary for arming, the checks that fail, and a summary of the parts; there
is a new one when something has changed, at most every two seconds. Ids, masks and parts are those of a recorded
session. A mode is a bit, the one of PX4's number for it.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from companion.mavlink.modes import Mode

PERIOD = 2.0
"""s between two reports at least, and until the first."""
NUMBERS = {
    Mode.MANUAL: 0, Mode.ALTITUDE: 1, Mode.POSITION: 2, Mode.MISSION: 3, Mode.HOLD: 4, Mode.RETURN: 5,
    Mode.POSITION_SLOW: 6, Mode.ALTITUDE_CRUISE: 8, Mode.ACRO: 10, Mode.DESCEND: 12, Mode.TERMINATION: 13,
    Mode.OFFBOARD: 14, Mode.STABILIZED: 15, Mode.TAKEOFF: 17, Mode.LAND: 18, Mode.FOLLOW: 19, Mode.PRECISION_LAND: 20,
    Mode.ORBIT: 21,
}  # fmt: skip
"""PX4's numbers of the modes (nav_state)."""


def bits(*modes: Mode) -> int:
    """The modes as bits."""
    return sum(1 << NUMBERS[mode] for mode in modes)


EVERY = 0x807FFFFF
"""Every mode there is, as bits."""
ALL_BITS = 0xFFFFFFFF
"""How PX4 writes both all modes and none in particular."""
WITH_STICKS = bits(
    Mode.MANUAL, Mode.ALTITUDE, Mode.POSITION, Mode.POSITION_SLOW, Mode.ALTITUDE_CRUISE, Mode.ACRO, Mode.STABILIZED
)  # fmt: skip
WITH_A_PLACE = 0x007E00FC
"""Modes that need the local position, as bits (recorded)."""
WITH_THE_GLOBE = bits(Mode.MISSION, Mode.HOLD, Mode.RETURN)
NOT_TO_ARM_IN = bits(
    Mode.RETURN, Mode.DESCEND, Mode.TERMINATION, Mode.LAND, Mode.FOLLOW, Mode.PRECISION_LAND, Mode.ORBIT
)  # fmt: skip
REMOTE_CONTROL = 7
"""Number of PX4's health component remote_control."""
COMMUNICATION = 12
"""Number of PX4's health component communication_links."""
LOCAL_POSITION = 17
"""Number of PX4's health component local_position_estimate."""
SYSTEM = 20
"""Number of PX4's health component system."""
GLOBAL_POSITION = 24
"""Number of PX4's health component global_position_estimate."""
PRESENT = 0x38020D02
"""The parts PX4's simulation has as soon as it is up; GPS and the link to an operator come later."""
GPS = 3
"""Its part's number."""
ARMING_SUMMARY = 11047904
"""Id of PX4's event arming_check_summary."""
HEALTH_SUMMARY = 1914663
"""Id of PX4's event health_summary."""
NO_STREAM = 11464574
"""Id of PX4's event that says that no offboard setpoints come."""
NOT_THIS_MODE = 1871713
"""Id of PX4's event that says that this mode cannot be armed in."""
NO_PLACE = 13835193
"""Id of PX4's event that says that there is no local position."""
NO_GLOBE = 10011251
"""Id of PX4's event that says that there is no global position."""
NO_MISSION = 377561
"""Id of PX4's event that says that there is no mission."""
NO_STICKS = 453929
"""Id of PX4's event that says that there is no manual control."""
NO_OPERATOR = 6801787
"""Id of PX4's event that says that there is no ground station."""
PROTOCOL = 0x88
"""Bits of PX4's log levels, internal and external: protocol."""
ERROR = 0x33
"""Bits of PX4's log levels, internal and external: error."""
WARNING = 0x44
"""Bits of PX4's log levels, internal and external: warning."""
INFO = 0x66
"""Bits of PX4's log levels, internal and external: info."""


class Health(NamedTuple):
    """What a report is made from. ``gcs_needed``, ``mission_needed``: parameters make these a matter of arming."""

    ready: bool
    armed: bool
    mode: Mode
    manual_control: bool
    offboard_signal: bool
    mission: bool
    gcs_connection: bool
    gcs_needed: bool
    mission_needed: bool


class HealthEvent(NamedTuple):
    """An event: its id, its log levels, its arguments."""

    id: int
    levels: int
    arguments: bytes


class Check(NamedTuple):
    """A check that fails: the modes nobody can arm in for it, those that cannot be flown, and the part concerned."""

    id: int
    levels: int
    argument: int
    no_arming: int
    no_flying: int
    part: int

    @property
    def event(self) -> HealthEvent:
        """Its event."""
        return HealthEvent(self.id, self.levels, struct.pack("<IB", self.argument, self.part))


def failing(health: Health) -> list[Check]:
    """What stands in the way."""
    checks = []
    offboard, mission = bits(Mode.OFFBOARD), bits(Mode.MISSION)
    if not health.offboard_signal:
        checks.append(Check(NO_STREAM, ERROR, offboard, offboard, offboard, SYSTEM))
    if not health.armed and NOT_TO_ARM_IN >> NUMBERS.get(health.mode, 0) & 1:
        checks.append(Check(NOT_THIS_MODE, INFO, NOT_TO_ARM_IN, NOT_TO_ARM_IN, 0, SYSTEM))
    if not health.ready:
        checks.append(Check(NO_PLACE, ERROR, WITH_A_PLACE, WITH_A_PLACE, WITH_A_PLACE, LOCAL_POSITION))
        checks.append(Check(NO_GLOBE, ERROR, WITH_THE_GLOBE, WITH_THE_GLOBE, WITH_THE_GLOBE, GLOBAL_POSITION))
    if not health.mission:
        kept = ALL_BITS if health.mission_needed else mission
        checks.append(Check(NO_MISSION, INFO, kept, kept, mission, SYSTEM))
    if not health.manual_control:
        checks.append(Check(NO_STICKS, WARNING, ALL_BITS, WITH_STICKS, WITH_STICKS, REMOTE_CONTROL))
    if not health.gcs_connection:
        kept, levels = (ALL_BITS, WARNING) if health.gcs_needed else (0, INFO)
        checks.append(Check(NO_OPERATOR, levels, ALL_BITS, kept, 0, COMMUNICATION))
    return checks


def report(health: Health) -> list[HealthEvent]:
    """The events of a report, in their order."""
    errors = warnings = 0
    can_arm = can_run = EVERY
    checks = failing(health)
    for check in checks:
        can_arm, can_run = can_arm & ~check.no_arming, can_run & ~check.no_flying
        errors |= (check.levels == ERROR) << check.part
        warnings |= (check.levels == WARNING) << check.part
    present = PRESENT | health.ready << GPS | health.gcs_connection << COMMUNICATION
    return [
        HealthEvent(ARMING_SUMMARY, PROTOCOL, struct.pack("<BIIII", 0, errors, warnings, can_arm, can_run)),
        *(check.event for check in checks),
        HealthEvent(HEALTH_SUMMARY, PROTOCOL, struct.pack("<BIII", 0, present, 0, 0)),
    ]


class HealthReport:
    """When it is said."""

    def __init__(self) -> None:
        self._health: Health | None = None
        self._next_at = PERIOD

    def update(self, t: float, health: Health) -> list[HealthEvent]:
        """What is to be said at ``t`` (s)."""
        if health == self._health or t < self._next_at:
            return []
        before, self._health, self._next_at = self._health, health, t + PERIOD
        said = report(health)
        return [] if before is not None and report(before) == said else said
