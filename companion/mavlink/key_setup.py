"""Giving a vehicle the key of a signed link (SETUP_SIGNING), without sockets or clocks.

There is no answer to SETUP_SIGNING: a vehicle that took the key signs from then on, so that is what is waited for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from companion.mavlink.codec import Decoder, Frame
from companion.mavlink.link import WANTED, Link
from companion.mavlink.peer import HEARTBEAT, Received
from companion.mavlink.signing import SETUP_SIGNING, SIGNED, Signing
from companion.mavlink_common import MAV_COMP_ID_AUTOPILOT1, MAV_MODE_FLAG_SAFETY_ARMED

ASK_PERIOD = 0.5
"""s between two SETUP_SIGNING, while the vehicle does not sign."""
TRIES = 6
"""times the key is sent: SETUP_SIGNING is not acknowledged."""
LOOK_FOR = 1.5
"""s of the vehicle's frames that are looked at before the key is sent: it may sign already."""
SIGNED_ENOUGH = 3
"""Signed frames of the vehicle that tell that it has the key."""


@dataclass
class KeySetup:
    """One attempt. ``done``: it signs with the key. ``refusal``: why it does not, in a sentence.

    Our own messages are signed as soon as the vehicle signs; the vehicle's are read whether they are signed or not.
    """

    signing: Signing
    stream: bool = False
    link: Link = field(default_factory=Link)
    done: bool = False
    already: bool = False
    refusal: str | None = None
    _decoder: Decoder = field(default_factory=lambda: Decoder(wanted=WANTED))
    _met_at: float = math.nan
    _asked_at: float = -math.inf
    _tries: int = 0
    _own: int = 0
    _foreign: int = 0

    @property
    def over(self) -> bool:
        """Whether there is nothing left to do."""
        return self.done or self.refusal is not None

    def receive(self, batch: list[Received], now: float) -> None:
        """Take in what arrived."""
        peers = self.link.peers
        for data, source in batch:
            if source == peers.heard:
                peers.heard_at = now
            elif not peers.knock(data, source, now):
                continue
            for frame in self._decoder.stream(data) if self.stream else self._decoder.piece(data, now):
                self.link.receive(frame, now)
                if self.link.of_vehicle(frame):
                    self._look(frame, now)

    def on_timer(self, now: float) -> None:
        """Send what is due."""
        self.link.on_timer(now)
        if self.over or math.isnan(self._met_at):
            return
        self.refusal = self._objection(now)
        if self.refusal is None and now >= max(self._met_at + LOOK_FOR, self._asked_at + ASK_PERIOD):
            self._asked_at = now
            self._tries += 1
            self.signing.advance(now)
            self.link.send(SETUP_SIGNING, SETUP_SIGNING.values(
                target_system=self.link.encoder.system, target_component=MAV_COMP_ID_AUTOPILOT1,
                secret_key=tuple(self.signing.key), initial_timestamp=self.signing.stamp,
            ))  # fmt: skip

    def _look(self, frame: Frame, now: float) -> None:
        """One message of the vehicle: whether it is armed, and with which key it is signed."""
        if math.isnan(self._met_at):
            self._met_at = now
        if frame.format is HEARTBEAT and frame.values[3] & MAV_MODE_FLAG_SAFETY_ARMED and not self._own:
            self.refusal = "the vehicle is armed; it takes a key only while it is disarmed"
        if not _is_signed(frame):
            return
        if self.signing.is_signed(frame.raw):
            self.link.encoder.signing = self.signing  # it follows our stamps, where its own are behind
            self._own += self.signing.accepts(frame.raw, frame.format.id)
        else:
            self._foreign += 1
        if self._own >= SIGNED_ENOUGH and not self.over:
            self.done, self.already = True, not self._tries

    def _objection(self, now: float) -> str | None:
        identity, peers = self.link.identity, self.link.peers
        assert identity is not None
        if not self.link.is_px4:
            return f"the autopilot that answered is not PX4 (MAV_AUTOPILOT {identity.autopilot}); no key was sent to it"
        if peers.rival is not None or self.link.others:
            return "two vehicles are heard; the key is given over a link with one alone"
        if self._foreign:
            return (
                "the vehicle signs with another key: only who has that one can change it; or delete "
                "mavlink/mavlink-signing-key.bin from its card"
            )
        if self._tries >= TRIES and now >= self._asked_at + ASK_PERIOD and not self._own:
            version = "of unknown version" if identity.version is None else "{}.{}.{}".format(*identity.version)
            return (
                f"the vehicle (PX4 {version}) goes on without signing: it has none, or takes no key on this link; "
                "PX4 signs where it has mavlink/message_signing in its documentation, with a card to keep the key on"
            )
        return None


def _is_signed(frame: Frame) -> bool:
    return frame.raw[0] == 0xFD and bool(frame.raw[2] & SIGNED)
