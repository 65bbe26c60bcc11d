"""What is asked of the vehicle: commands with acknowledgement and retry.

A ``Command`` is a COMMAND_LONG as a value. ``Requests`` asks for what is to be set up once (streams, single messages),
one after the other, and sends the flight's own commands, each as often as the flight decides (``flight.asking``).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.mavlink.dialect import message
from companion.mavlink_common import (
    MAV_CMD_COMPONENT_ARM_DISARM,
    MAV_CMD_DO_SET_MODE,
    MAV_CMD_IMAGE_START_CAPTURE,
    MAV_CMD_IMAGE_STOP_CAPTURE,
    MAV_CMD_NAV_LAND,
    MAV_CMD_NAV_TAKEOFF,
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_CAMERA_FOCUS,
    MAV_CMD_SET_CAMERA_MODE,
    MAV_CMD_SET_CAMERA_ZOOM,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_CMD_VIDEO_START_CAPTURE,
    MAV_CMD_VIDEO_STOP_CAPTURE,
    MAV_COMP_ID_AUTOPILOT1,
    MAV_COMP_ID_CAMERA,
    MavResult,
)
from companion.vehicle import Mode

COMMAND_LONG = message("COMMAND_LONG")

CUSTOM_MODE_ENABLED = 1.0
"""MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, DO_SET_MODE's first parameter."""

RETRY_UNANSWERED = 0.5
"""s until a message that is set up is asked for again."""
ANSWER_WITHIN = 1.0
"""s after which no answer to a command is waited for: five times the slowest link that is flown with."""

SET_UP_TRIES = 10
"""times a command of the set-up is sent before the flight does without."""


@dataclass(frozen=True, slots=True)
class Command:
    """A COMMAND_LONG: its id, seven parameters, and the component of the vehicle that it is for."""

    id: int
    parameters: tuple[float, ...] = ()
    component: int = MAV_COMP_ID_AUTOPILOT1

    @property
    def padded(self) -> tuple[float, ...]:
        """Seven parameters, zero where not given."""
        return self.parameters + (0.0,) * (7 - len(self.parameters))


UNUSED = (math.nan,) * 7
"""Parameters of a command that say nothing."""
CAMERA_COMMANDS = frozenset({
    MAV_CMD_SET_CAMERA_MODE, MAV_CMD_SET_CAMERA_ZOOM, MAV_CMD_SET_CAMERA_FOCUS, MAV_CMD_IMAGE_START_CAPTURE,
    MAV_CMD_IMAGE_STOP_CAPTURE, MAV_CMD_VIDEO_START_CAPTURE, MAV_CMD_VIDEO_STOP_CAPTURE,
})  # fmt: skip
"""What MAVLink's camera protocol gives to the camera's own component."""


def set_mode(mode: Mode) -> Command:
    """Asks for a flight mode."""
    return Command(MAV_CMD_DO_SET_MODE, (CUSTOM_MODE_ENABLED, float(mode.main), float(mode.sub)))


ARM = Command(MAV_CMD_COMPONENT_ARM_DISARM, (1.0,))
DISARM = Command(MAV_CMD_COMPONENT_ARM_DISARM, (0.0,))
AUTO_TAKE_OFF = Command(MAV_CMD_NAV_TAKEOFF, UNUSED)
AUTO_LAND = Command(MAV_CMD_NAV_LAND, UNUSED)


def request(msgid: int) -> Command:
    """Asks for a message once."""
    return Command(MAV_CMD_REQUEST_MESSAGE, (float(msgid),))


def stream(msgid: int, rate: float) -> Command:
    """Asks for a message at ``rate`` Hz."""
    return Command(MAV_CMD_SET_MESSAGE_INTERVAL, (float(msgid), float(round(1e6 / rate))))


def payload(command: int, parameters: tuple[float, ...]) -> Command:
    """A command for the payload: a MAVLink camera's own for the camera, the others for the autopilot."""
    return Command(command, parameters, MAV_COMP_ID_CAMERA if command in CAMERA_COMMANDS else MAV_COMP_ID_AUTOPILOT1)


@dataclass(slots=True)
class _Pending:
    command: Command
    sent_at: float
    tries: int = 1


@dataclass(slots=True)
class Requests:
    """What is asked of one vehicle. ``send(command, confirmation)`` queues one COMMAND_LONG. Times: s, our clock."""

    send: Callable[[Command, int], None]
    _unanswered: list[tuple[Command, float]] = field(default_factory=list)
    _set_up: list[Command] = field(default_factory=list)
    _setting_up: _Pending | None = None

    @property
    def is_set_up(self) -> bool:
        """Whether everything that is asked once was answered, or will not be."""
        return not self._set_up

    def set_up(self, commands: list[Command]) -> None:
        """Ask for these once, one after the other, from the next ``on_timer`` on."""
        self._set_up = commands

    def ask(self, command: Command, confirmation: int, now: float) -> None:
        """Send a command of the flight, once. ``confirmation``: how often it was sent before, unanswered."""
        self._unanswered.append((command, now))
        self.send(command, min(confirmation, 255))

    def match_acknowledgement(
        self, command: int, result: int, now: float, component: int = MAV_COMP_ID_AUTOPILOT1
    ) -> tuple[Command, int] | None:
        """A COMMAND_ACK for us. The command of the flight that it answers, and its MAV_RESULT.

        The autopilot answers in order: where several with the same id wait, it is the oldest one's. So an answer may be
        taken for another's that was lost, and its own command is then sent once more; never is a command taken for
        accepted that was not.
        """
        setting_up = self._setting_up if component == MAV_COMP_ID_AUTOPILOT1 else None
        if setting_up is not None and command == setting_up.command.id:
            # the autopilot answers in order, so the answer is to the one that was sent last
            if result != 1 or setting_up.tries > 3:
                self._next_set_up(now)
            return None
        self._unanswered = [(asked, at) for asked, at in self._unanswered if now - at < ANSWER_WITHIN]
        for index, (asked, _) in enumerate(self._unanswered):
            if asked.id == command and asked.component == component:
                del self._unanswered[index]
                if result == MavResult.IN_PROGRESS:  # it has begun; how it ends is told in another answer
                    self._unanswered.insert(index, (asked, now))
                return asked, result
        return None

    def on_timer(self, now: float) -> None:
        """Send what is due of what is set up."""
        if self._setting_up is None and self._set_up:
            self._setting_up = _Pending(self._set_up[0], now)
            self.send(self._set_up[0], 0)
        elif self._setting_up is not None and now >= self._setting_up.sent_at + RETRY_UNANSWERED:
            tries = self._setting_up.tries
            if tries >= SET_UP_TRIES:
                self._next_set_up(now)
                return
            self._setting_up = _Pending(self._set_up[0], now, tries + 1)
            self.send(self._set_up[0], min(tries, 255))

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        return math.inf if self._setting_up is None else self._setting_up.sent_at + RETRY_UNANSWERED

    def _next_set_up(self, now: float) -> None:
        self._set_up.pop(0)
        self._setting_up = None
        self.on_timer(now)
