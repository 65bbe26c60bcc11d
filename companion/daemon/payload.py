"""The payload's commands on the link: each is sent once, and what comes of it is said.

A command that is lost is not sent again: it belongs to a place that is behind by then. Of many alike that come to
nothing the first is told, and their number in the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.mavlink import requests
from companion.mavlink.requests import Command, Requests
from companion.mavlink_common import MavResult
from companion.mission import PathAction


@dataclass
class Payload:
    """``say``: a line for people."""

    say: Callable[[str], None]
    sent: int = 0
    accepted: int = 0
    _waiting: list[tuple[PathAction, Command, float]] = field(default_factory=list)
    _failed: dict[tuple[int, str], int] = field(default_factory=dict)

    def send(self, actions: tuple[PathAction, ...], link: Requests, now: float) -> None:
        """Send what is due."""
        for action in actions:
            command = requests.payload(action.command, action.params)
            link.ask(command, 0, now)
            self.sent += 1
            self._waiting.append((action, command, now))

    def take_answer(self, command: Command, result: int, now: float) -> bool:
        """Whether a command that was answered is one of the payload's."""
        for index, (action, waiting, _) in enumerate(self._waiting):
            if waiting is command:
                del self._waiting[index]
                if result == MavResult.ACCEPTED:
                    self.accepted += 1
                elif result == MavResult.IN_PROGRESS:
                    self._waiting.append((action, waiting, now))
                else:
                    self._fail(action, MavResult(result).words if result in set(MavResult) else f"result {result}")
                return True
        return False

    def on_timer(self, now: float) -> None:
        """Give up what was not answered."""
        while self._waiting and now >= self._waiting[0][2] + requests.ANSWER_WITHIN:
            self._fail(self._waiting.pop(0)[0], "no answer")

    def next_timer(self) -> float:
        """When ``on_timer`` has something to do."""
        return self._waiting[0][2] + requests.ANSWER_WITHIN if self._waiting else math.inf

    def finish(self) -> None:
        """Say what came of it all."""
        for action, _, _ in self._waiting:
            self._fail(action, "no answer")
        self._waiting.clear()
        if self.sent:
            failed = ", ".join(f"{count} times {words}" for (_, words), count in self._failed.items())
            more = f"; {failed}" if failed else ""
            self.say(f"payload: {self.sent} commands sent, {self.accepted} accepted by the vehicle{more}")
            self.sent = 0

    def _fail(self, action: PathAction, words: str) -> None:
        known = (action.command, words)
        self._failed[known] = self._failed.get(known, 0) + 1
        if self._failed[known] == 1:
            self.say(
                f"payload: item {action.number} (command {action.command}) at {action.s:.1f} m: {words}; the flight "
                "goes on, look at the camera or the servo it is for"
            )
