"""What happens in the commander, told to everybody: texts and events to the links, lines for a person."""

from __future__ import annotations

from collections.abc import Sequence

from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.mavlink.link import Link

TEXTS = 8
"""Number of texts that are said within TEXTS_PERIOD; what is beyond is dropped, as by PX4's queue."""
TEXTS_PERIOD = 0.1
"""s."""


class Teller:
    """``log``: lines for a person, to be taken out by whoever shows them."""

    def __init__(self, autopilot: Autopilot, links: Sequence[Link]) -> None:
        self._autopilot, self._links = autopilot, links
        self.log: list[str] = []
        self._noted = ("", 0.0)
        self._texts_left, self._tell_again_at = TEXTS, 0.0
        self._logged = autopilot.commander.mode

    def tell(self, now: float) -> None:
        """Send and log the commander's texts, and log what has changed. ``now``: s of the bridge's clock."""
        autopilot, commander = self._autopilot, self._autopilot.commander
        if commander.texts:
            for text in commander.texts:
                self._note(text.text.rstrip("\t"), now)
                if now >= self._tell_again_at:
                    self._texts_left, self._tell_again_at = TEXTS, now + TEXTS_PERIOD
                if self._texts_left > 0:
                    self._texts_left -= 1
                    autopilot.events.keep_text(
                        text, autopilot.estimate.time_us, commander.user_intended_mode, commander.mode
                    )  # fmt: skip
                    for link in self._links:
                        link.say(text)
            commander.texts.clear()
        mode = commander.mode
        if mode is not self._logged:
            self._logged = mode
            self._note(f"mode {mode.name}{'' if commander.failsafe is None else ' (failsafe)'}", now)

    def _note(self, line: str, now: float) -> None:
        """Log a line, but not again and again what somebody provokes many times a second."""
        if line != self._noted[0] or now - self._noted[1] >= 1.0:
            self.log.append(line)
            self._noted = (line, now)
