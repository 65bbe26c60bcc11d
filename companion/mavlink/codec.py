"""Bytes <-> frames: MAVLink 2 (and MAVLink 1 on the way in) on the dialect's tables.

Every frame of a message we know is checked against its CRC, including those nobody asked for: a false start byte must
not swallow the good frame behind it. What cannot be decoded is counted, never raised. The work is bounded by the size
of the input, whatever it holds: bytes that look like a frame begun at every place are given up as garbage.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import NamedTuple

from fastcrc.crc16 import mcrf4xx

from companion.mavlink.counters import Counters
from companion.mavlink.dialect import FORMATS, Format, Value
from companion.mavlink.signing import SETUP_SIGNING, SIGNATURE_SIZE, SIGNED, Signing

MAGIC_V2 = 0xFD
"""The first byte of a MAVLink 2 frame."""
MAGIC_V1 = 0xFE
"""The first byte of a MAVLink 1 frame."""

LATE_FROM = 192
"""A sequence number so many ahead of the last one, of 256, is taken for one that is behind it."""

UNKNOWN_ID = -1
"""In the place of the id of a message that we do not know."""

DATAGRAM_MAX = 8192
"""bytes of a datagram that are looked at: 29 of MAVLink's longest frames. Routers and bridges send at most 1500."""
UNFINISHED_MAX = 0.1
"""s that the beginning of a frame is kept for its rest, where datagrams are pieces of a byte stream: the longest frame
takes 49 ms at 57600 baud (engineering choice)."""
FALSE_STARTS, BYTES_PER_FALSE_START = 32, 16
"""Starts that turn out to be none, after which the rest of an input is garbage: 32, and one in 16 bytes. Noise has one
in 230 bytes; a flood of start bytes would otherwise cost a CRC of up to 280 bytes each."""

_START = re.compile(rb"\xfd(?:.(?:[\x00\x01]|\Z)|\Z)|\xfe", re.DOTALL)
"""A start byte; of MAVLink 2 only with flags that we know: the specification has what asks for others discarded."""


class Frame(NamedTuple):
    """One decoded message: ``values`` flat in wire order (see ``dialect.Format``), ``raw`` the bytes as they came."""

    format: Format
    system: int
    component: int
    values: tuple[Value, ...]
    raw: bytes


@dataclass(slots=True)
class Decoder:
    """Decodes what one peer sends.

    ``wanted``: the message ids to unpack; None for every known one. ``tap``: called with the bytes of every whole
    frame, whether anybody wants it or not; but not of one that carries a key. ``signing``: what it does not accept has
    no effect, and is not given to ``tap``.
    """

    wanted: Collection[int] | None = None
    tap: Callable[[bytes], None] | None = None
    counters: Counters = field(default_factory=Counters)
    signing: Signing | None = None
    _sequence: dict[int, int] = field(default_factory=dict)
    _pending: bytes = b""
    _pending_at: float = -math.inf

    def datagram(self, data: bytes) -> list[Frame]:
        """The frames in one datagram. What is left over does not touch the next datagram. Never raises."""
        frames = self._whole(data)
        if frames is not None:
            return frames
        data = self._bound(data)
        frames, used = self._scan(data)
        self.counters.garbage_bytes += len(data) - used
        return frames

    def piece(self, data: bytes, now: float) -> list[Frame]:
        """The frames completed by a datagram that came at ``now`` (s) from a peer whose datagrams may be cut anywhere,
        as bridges from serial lines to UDP do. A frame that is begun is kept UNFINISHED_MAX at most; a whole frame at a
        datagram's start is believed before any completion. Never raises."""
        frames = self._whole(data)
        pending = self._pending
        if not pending and frames is not None:
            return frames
        data = self._bound(data)
        if pending and (now - self._pending_at > UNFINISHED_MAX or frames is not None or _begins_whole(data)):
            self.counters.garbage_bytes += len(pending)
            self._pending = pending = b""
            if frames is not None:
                return frames
        joined = pending + data
        frames, used = self._scan(joined)
        if used >= len(pending):
            self._pending_at = now
        self._pending = joined[used:]
        return frames

    def restart(self) -> None:
        """Another sender speaks from now on: nothing is waited for, and no sequence is continued."""
        self._pending = b""
        self._sequence.clear()

    def _whole(self, data: bytes) -> list[Frame] | None:
        """The frames of a datagram that is one whole MAVLink 2 frame and no more: the usual case, quickly."""
        size = len(data)
        if size < 12 or data[0] != MAGIC_V2:
            return None
        check, flags = data[1] + 10, data[2]
        if size != (check + 2 if not flags else check + 2 + SIGNATURE_SIZE) or flags > SIGNED:
            return None
        fmt = FORMATS.get(data[7] | data[8] << 8 | data[9] << 16)
        if fmt is None or not _crc_fits(fmt, data, 0, check):
            return None
        return self._accept(fmt, data, data[4], data[5], data[6], data[10:check])

    def _bound(self, data: bytes) -> bytes:
        if len(data) <= DATAGRAM_MAX:
            return data
        self.counters.garbage_bytes += len(data) - DATAGRAM_MAX
        return data[:DATAGRAM_MAX]

    def stream(self, chunk: bytes) -> list[Frame]:
        """The frames completed by ``chunk`` of a byte stream (a serial line). Never raises."""
        data = self._pending + chunk
        frames, used = self._scan(data)
        self._pending = data[used:]
        return frames

    def _scan(self, data: bytes) -> tuple[list[Frame], int]:
        """The frames in ``data`` and how many bytes are dealt with: all but a frame that might still be arriving."""
        frames: list[Frame] = []
        counters = self.counters
        size = len(data)
        done = 0  # everything before is decoded or counted as garbage
        unfinished = size  # where the first frame begins that runs past the end
        # a frame without a CRC to check (start, end, sequence, sender): believed when nothing good is inside it
        unknown: tuple[int, int, int, int] | None = None
        at = -1
        false_starts_left = FALSE_STARTS + size // BYTES_PER_FALSE_START
        while True:
            if not false_starts_left:  # not a link that is merely disturbed
                counters.garbage_bytes += size - done
                return frames, size
            found = _START.search(data, at + 1)
            at = size if found is None else found.start()
            if unknown is not None and at >= unknown[1]:
                done, unknown = self._pass_unknown(data, done, unknown), None
            if at == size:
                break
            signature = 0
            end = size + 1
            if data[at] == MAGIC_V2:
                header = 10
                if size - at >= 12:
                    length, flags, _, sequence, system, component, low, middle, high = data[at + 1 : at + 10]
                    if flags:
                        signature = SIGNATURE_SIZE
                    msgid = low | middle << 8 | high << 16
                    end = at + 12 + length + signature
            else:
                header = 6
                if size - at >= 8:
                    length, sequence, system, component, msgid = data[at + 1 : at + 6]
                    end = at + 8 + length
            if end > size:
                false_starts_left -= 1
                unfinished = min(unfinished, at)
                continue
            fmt = FORMATS.get(msgid)
            if fmt is None:
                false_starts_left -= 1
                fits = end == size or data[end] in (MAGIC_V1, MAGIC_V2)
                if fits and unknown is None and unfinished == size:
                    unknown = (at, end, sequence, system << 8 | component)
                continue
            check = end - signature - 2
            if not _crc_fits(fmt, data, at, check):
                false_starts_left -= 1
                counters.bad_crc += unknown is None and unfinished == size
                continue
            frames += self._accept(fmt, data[at:end], sequence, system, component, data[at + header : check])
            counters.garbage_bytes += at - done
            done = end
            unfinished = size
            unknown = None
            at = end - 1
        counters.garbage_bytes += unfinished - done
        return frames, unfinished

    def _pass_unknown(self, data: bytes, done: int, unknown: tuple[int, int, int, int]) -> int:
        """Where a frame of a message that is not known here ends: what lies before it is garbage."""
        start, end, sequence, sender = unknown
        raw = data[start:end]
        if self.signing is None or self.signing.accepts(raw, UNKNOWN_ID):
            self.counters.unknown += 1
            self._follow(sender, sequence)
            if self.tap is not None:
                self.tap(raw)
        self.counters.garbage_bytes += start - done
        return end

    def _accept(
        self, fmt: Format, raw: bytes, sequence: int, system: int, component: int, payload: bytes
    ) -> list[Frame]:
        """Count a whole frame, and unpack it where it is wanted."""
        if self.signing is not None and not self.signing.accepts(raw, fmt.id):
            return []
        self.counters.frames += 1
        self._follow(system << 8 | component, sequence)
        if self.tap is not None and fmt is not SETUP_SIGNING:
            self.tap(raw)
        if self.wanted is not None and fmt.id not in self.wanted:
            return []
        if (
            len(payload) != fmt.size
        ):  # MAVLink 2 cuts trailing zeros off; a newer sender may know more fields than we do
            payload = payload.ljust(fmt.size, b"\0")[: fmt.size]
        return [Frame(fmt, system, component, fmt.unpack(payload), raw)]

    def _follow(self, sender: int, sequence: int) -> None:
        """Count what is missing between a sender's last frame and this one; one that comes late was not lost."""
        last = self._sequence.get(sender)
        if last is not None:
            missing = (sequence - last - 1) & 0xFF
            if missing >= LATE_FROM:
                if missing != 0xFF and self.counters.lost:  # 255: the same once more
                    self.counters.lost -= 1
                return
            self.counters.lost += missing
        self._sequence[sender] = sequence


def _begins_whole(data: bytes) -> bool:
    """Whether the first bytes are a whole frame of a known message, its CRC right."""
    size = len(data)
    if size < 12:
        return False
    if data[0] == MAGIC_V2 and data[2] <= SIGNED:
        check = 10 + data[1]
        fmt = FORMATS.get(data[7] | data[8] << 8 | data[9] << 16)
        end = check + 2 + (SIGNATURE_SIZE if data[2] & SIGNED else 0)
    else:
        check = 6 + data[1]
        fmt = FORMATS.get(data[5]) if data[0] == MAGIC_V1 else None
        end = check + 2
    return fmt is not None and end <= size and _crc_fits(fmt, data, 0, check)


def _crc_fits(fmt: Format, data: bytes, start: int, check: int) -> bool:
    """Whether the two bytes at ``check`` are the CRC of what lies between them and the start byte."""
    crc: int = mcrf4xx(fmt.crc_extra_byte, mcrf4xx(data[start + 1 : check]))
    return crc == data[check] | data[check + 1] << 8


_HEAD = struct.Struct("<6BHB").pack
"""Length, two bytes of flags, sequence, system, component, message id in three bytes."""
_CRC = struct.Struct("<H").pack


@dataclass(slots=True)
class Encoder:
    """Frames messages as one MAVLink component: MAVLink 2, sequence numbers counted here, signed with ``signing``."""

    system: int
    component: int
    sequence: int = 0
    signing: Signing | None = None

    def encode(self, fmt: Format, values: tuple[Value, ...]) -> bytes:
        """The frame of ``values`` (flat, wire order), its trailing zero bytes cut. A number that its type on the wire
        cannot hold becomes the nearest that it can. struct.error, ValueError: they are not this message's values."""
        try:
            payload = fmt.pack(*values)
        except (struct.error, OverflowError):
            payload = fmt.pack(*fmt.clamped(values))
        payload = payload.rstrip(b"\0") or b"\0"
        sequence, msgid = self.sequence, fmt.id
        self.sequence = sequence + 1 & 0xFF
        signing = self.signing
        flags = 0 if signing is None else SIGNED
        head = _HEAD(len(payload), flags, 0, sequence, self.system, self.component, msgid & 0xFFFF, msgid >> 16)
        body = head + payload
        frame = b"\xfd" + body + _CRC(mcrf4xx(fmt.crc_extra_byte, mcrf4xx(body)))
        return frame if signing is None else frame + signing.signature(frame)

    def message(self, fmt: Format, **fields: Value) -> bytes:
        """The frame of a message given by field names; fields left out are zero. Not for the hot path."""
        return self.encode(fmt, fmt.values(**fields))
