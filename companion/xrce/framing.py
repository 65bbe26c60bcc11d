"""Messages <-> the bytes of a serial line, both directions: eProsima's framing, after HDLC.

    7E, to whom, from whom, length (u16), message, CRC-16/ARC of the message (u16); little endian

After the first byte 7E and 7D are sent as 7D and the byte XOR 20. There is no byte at the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from fastcrc.crc16 import arc

from companion.xrce.agent import Counters

AGENT, CLIENT = 0, 1
"""Addresses on the line, as PX4 has them."""
TURNED = 0x20
"""What a byte that is escaped is XORed with."""
LENGTH_MAX = 2048
"""bytes of a message that are waited for: PX4's have 512 at most (UXRCE_DDS_CFG's transports)."""
_HEAD, _TAIL = 4, 2


def framed(message: bytes, source: int, destination: int) -> bytes:
    """The frame of a message."""
    head = bytes((source, destination)) + len(message).to_bytes(2, "little")
    body = head + message + arc(message).to_bytes(2, "little")
    return b"\x7e" + body.replace(b"\x7d", b"\x7d\x5d").replace(b"\x7e", b"\x7d\x5e")


@dataclass(slots=True)
class Deframer:
    """What comes over a line for ``own`` address. ``counters``: where frames that were none are counted."""

    own: int
    counters: Counters = field(default_factory=Counters)
    _pending: bytes = b""

    def receive(self, chunk: bytes) -> list[bytes]:
        """The messages that are whole now. Never raises."""
        *frames, last = (self._pending + chunk).split(b"\x7e")
        found = [self._message(frame) for frame in frames if frame]
        self._pending = b""
        if last or frames:
            found.append(self._message(last))
            if found[-1] is None and len(last) <= 2 * LENGTH_MAX:
                self._pending = b"\x7e" + last  # its rest is still to come
                found.pop()
        self.counters.garbage += sum(not message for message in found)
        return [message for message in found if message]

    def _message(self, frame: bytes) -> bytes | None:
        """The message of a frame without its first byte; empty: it is not for us, or spoilt; None: it is cut short."""
        head, *rest = frame.split(b"\x7d")
        body = head + b"".join(bytes((part[0] ^ TURNED,)) + part[1:] for part in rest if part)
        length = int.from_bytes(body[2:4], "little")
        end = _HEAD + length
        if length > LENGTH_MAX:
            return b""
        if len(body) < end + _TAIL:
            return None
        message = body[_HEAD:end]
        fits = body[1] == self.own and arc(message) == int.from_bytes(body[end : end + _TAIL], "little")
        return message if fits else b""
