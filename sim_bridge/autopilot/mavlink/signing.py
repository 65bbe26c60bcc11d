"""Signing as PX4 does it (mavlink_sign_control): one key for the vehicle, on all links, given by SETUP_SIGNING.

Without a key nothing is signed and everything is accepted. With one every message is signed, and what is not signed
with it is dropped and not forwarded, but for UNSIGNED_ACCEPTED. A key is taken only while disarmed, and where there is
one already only in a message that is signed with it; all zeros take it away. The stamps count messages, not time: PX4
has no clock for them, and follows the stamps that it hears.
"""

from __future__ import annotations

from companion.mavlink.codec import Decoder, Encoder, Frame
from companion.mavlink.dialect import message
from companion.mavlink.signing import KEY_SIZE, SETUP_SIGNING, STAMP_MAX, Signing, Stream

UNSIGNED_ACCEPTED = frozenset(message(name).id for name in ("HEARTBEAT", "RADIO_STATUS", "ADSB_VEHICLE", "COLLISION"))
"""PX4's list: these count even if their signature is wrong or missing."""


class KeyStore:
    """The vehicle's key, as PX4 keeps it on its card: ``key`` None where there is none. ``streams``: of all links."""

    def __init__(self, key: bytes | None = None) -> None:
        self.key = key
        self._stamp = 0
        self._streams: dict[Stream, int] = {}
        self._links: list[tuple[Encoder, Decoder]] = []

    def attach(self, encoder: Encoder, decoder: Decoder) -> None:
        """One more link, by its order from 0."""
        self._links.append((encoder, decoder))
        self._install(len(self._links) - 1)

    def use_key(self, key: bytes | None, stamp: int) -> None:
        """Another key, on all links, from ``stamp`` on."""
        self.key, self._stamp = key, stamp
        self._streams.clear()
        for number in range(len(self._links)):
            self._install(number)

    def set_up(self, frame: Frame, system: int, component: int, *, armed: bool) -> None:
        """SETUP_SIGNING came: the decoder has seen to it that it is signed, where there is a key."""
        values = SETUP_SIGNING.named(frame.values)
        target = values["target_system"], values["target_component"]
        if armed or target[0] not in (0, system) or target[1] not in (0, component):
            return
        key = bytes(values["secret_key"])
        self.use_key(
            key if any(key) or values["initial_timestamp"] else None, min(values["initial_timestamp"], STAMP_MAX)
        )

    def _install(self, number: int) -> None:
        encoder, decoder = self._links[number]
        signing = None
        if self.key is not None:
            signing = Signing(
                self.key.ljust(KEY_SIZE, b"\0"), number, self._stamp, self._streams, unsigned_accepted=UNSIGNED_ACCEPTED
            )
        encoder.signing = decoder.signing = signing
