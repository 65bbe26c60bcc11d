"""What is written to the vehicle's own topics from outside, past its MAVLink side: PX4's uORB over XRCE.

Nothing in PX4 keeps such a write out of its own modes: whoever reads a topic takes what was written to it last. Where a
loop of the vehicle's writes the same topic, its next output stands again: a write counts for one step.
"""

from __future__ import annotations

import enum

from sim_bridge.autopilot.flight_modes.setpoints import (
    ActuatorMotors,
    AttitudeSetpoint,
    MotorSetpoint,
    RatesSetpoint,
    Setpoint,
    TorqueSetpoint,
)


class Level(enum.IntEnum):
    """What offboard_control_mode asks PX4 to take, in the order of its flags."""

    POSITION = 0
    VELOCITY = 1
    ACCELERATION = 2
    ATTITUDE = 3
    RATES = 4
    TORQUES = 5
    MOTORS = 6


TopicSetpoint = ActuatorMotors | TorqueSetpoint | RatesSetpoint | AttitudeSetpoint
PAST_THE_LOOPS = (ActuatorMotors, TorqueSetpoint)
"""Those that none of the vehicle's control loops reads."""
LEVEL_OF: dict[type[Setpoint], Level] = {
    MotorSetpoint: Level.MOTORS,
    ActuatorMotors: Level.MOTORS,
    TorqueSetpoint: Level.TORQUES,
    RatesSetpoint: Level.RATES,
    AttitudeSetpoint: Level.ATTITUDE,
}
"""The level of a setpoint; of all others the highest."""


class Topics:
    """``level``: what the last offboard_control_mode asks for; None: the last one was MAVLink's, or none has come."""

    def __init__(self) -> None:
        self.level: Level | None = None
        self._last: dict[Level, TopicSetpoint] = {}
        self._fresh: dict[Level, TopicSetpoint] = {}

    def write(self, written: TopicSetpoint) -> None:
        """A topic is written."""
        level = LEVEL_OF[type(written)]
        self._last[level] = self._fresh[level] = written

    @property
    def any(self) -> bool:
        """Whether any was written that the vehicle's own loops have not written since."""
        return bool(self._last)

    def wanted(self, level: Level) -> TopicSetpoint | None:
        """What is flown at a level; None: it has not been written since the vehicle's own loops wrote it."""
        return self._last.get(level)

    def take_fresh(self, flown: Level) -> TopicSetpoint | None:
        """What was written since the last step below the level that is flown: the lowest of it counts, and then the
        vehicle's loops have written there again."""
        fresh, self._fresh = self._fresh, {}
        self._last = {level: written for level, written in self._last.items() if level <= flown}
        lowest = max(fresh, default=None)
        return None if lowest is None or lowest <= flown else fresh[lowest]


def level_of(flags: tuple[bool, ...]) -> Level | None:
    """What offboard_control_mode's seven flags ask for: the first that is set. None: nothing, which does not count."""
    return next((level for level in Level if flags[level]), None)
