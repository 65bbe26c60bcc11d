"""MAVLink 2 message signing: every frame of ours signed, every frame of others checked. No clock and no file here.

A signature is 13 bytes behind the CRC: the link's number, a time stamp of 6 bytes, and 6 bytes of the SHA-256 of the
key and all before. Stamps count 10 us since 2015 and only ever grow, for each stream (system, component, link); so a
message that was heard once is refused the second time (MAVLink's guide, "Message Signing").
"""

from __future__ import annotations

from dataclasses import dataclass, field
from hashlib import sha256
from hmac import compare_digest
from typing import Any

from companion.mavlink.dialect import message

SIGNED = 0x01
"""The incompatibility flag of a signed frame."""
SIGNATURE_SIZE = 13
"""bytes at a signed frame's end: link id, stamp, signature (MAVLink 2 specification)."""
KEY_SIZE = 32
"""bytes of a signing key (MAVLink 2 specification)."""
TICK = 1e-5
"""s of one count of a time stamp."""
EPOCH = 1420070400
"""2015-01-01T00:00:00Z in s since 1970: where time stamps count from."""
STAMP_MAX = (1 << 48) - 1
"""The greatest stamp of 48 bits."""
BEHIND_MAX = 6_000_000
"""Ticks, a minute: how far behind our own the first stamp of a new stream may be (MAVLink's guide)."""
STREAMS_MAX = 64
"""Streams that are remembered (engineering choice): only who has the key makes one."""

SETUP_SIGNING = message("SETUP_SIGNING")
RADIO_STATUS = message("RADIO_STATUS")
UNSIGNED_ACCEPTED = frozenset({RADIO_STATUS.id})
"""Radios tell of the link themselves, and have no key."""

Stream = tuple[int, int, int]
"""System, component, link."""


@dataclass(slots=True)
class RefusedFrames:
    """Frames that had no effect: without a signature, with a wrong one, with an old stamp."""

    unsigned: int = 0
    forged: int = 0
    replayed: int = 0

    @property
    def total(self) -> int:
        """All of them."""
        return self.unsigned + self.forged + self.replayed

    def __str__(self) -> str:
        return f"{self.unsigned} unsigned, {self.forged} forged and {self.replayed} replayed messages"


@dataclass(slots=True)
class Signing:
    """One side of a signed link. ``stamp``: the last that was sent or heard. ``streams``: the last stamp of each.
    ``unsigned_accepted``: messages that count without a signature. ``epoch``: s since 1970 when the clock of
    ``advance`` read zero."""

    key: bytes = field(repr=False)
    link: int = 0
    stamp: int = 0
    streams: dict[Stream, int] = field(default_factory=dict)
    unsigned_accepted: frozenset[int] = UNSIGNED_ACCEPTED
    epoch: float = 0.0
    refused: RefusedFrames = field(default_factory=RefusedFrames)
    _begun: Any = field(init=False, repr=False)  # hashlib names no type for its objects

    def __post_init__(self) -> None:
        self._begun = sha256(self.key)

    def advance(self, now: float) -> None:
        """Time passes (s). A clock that is set back does not set the stamps back."""
        self.stamp = max(self.stamp, min(round((self.epoch + now - EPOCH) / TICK), STAMP_MAX))

    def signature(self, frame: bytes) -> bytes:
        """What goes behind a frame that ends with its CRC and has the flag SIGNED."""
        self.stamp = stamp = min(self.stamp + 1, STAMP_MAX)
        header = self.link.to_bytes(1, "little") + stamp.to_bytes(6, "little")
        hashed = self._begun.copy()
        hashed.update(frame)
        hashed.update(header)
        return header + bytes(hashed.digest()[:6])

    def is_signed(self, frame: bytes) -> bool:
        """Whether a frame with a signature was signed with the key, some time."""
        hashed = self._begun.copy()
        hashed.update(frame[:-6])
        return compare_digest(hashed.digest()[:6], frame[-6:])

    def accepts(self, frame: bytes, msgid: int) -> bool:
        """Whether a whole frame may have an effect; it is counted where it may not."""
        excepted = msgid in self.unsigned_accepted
        if frame[0] != 0xFD or not frame[2] & SIGNED:
            self.refused.unsigned += not excepted
            return excepted
        if not self.is_signed(frame):
            self.refused.forged += not excepted
            return excepted
        stamp = int.from_bytes(frame[-12:-6], "little")
        stream = (frame[5], frame[6], frame[-13])
        last = self.streams.get(stream)
        is_new = last is None and stamp + BEHIND_MAX >= self.stamp and len(self.streams) < STREAMS_MAX
        if not is_new and (last is None or stamp <= last):
            self.refused.replayed += not excepted
            return excepted
        self.streams[stream] = stamp
        if stamp > self.stamp:
            self.stamp = stamp
        return True
