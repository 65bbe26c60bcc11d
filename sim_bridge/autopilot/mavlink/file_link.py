"""MAVLink FTP on one link: reading what files.py offers, and the vehicle's own logs. Nothing can be written.

Payload: sequence (2), session, opcode, size, request opcode, burst complete, padding, offset (4), data (239).
"""

from __future__ import annotations

import enum
import struct
import zlib
from collections.abc import Callable, Mapping
from pathlib import PurePosixPath

from companion.mavlink.codec import Frame
from companion.mavlink.dialect import Format, Value, message
from sim_bridge.autopilot.mavlink.files import DIRECTORIES, FILES

FTP = message("FILE_TRANSFER_PROTOCOL")
HEADER = struct.Struct("<HBBBBBBI")
PAYLOAD = 251
"""bytes of FILE_TRANSFER_PROTOCOL's payload."""
DATA = PAYLOAD - HEADER.size
BURST = 20
"""Packets a burst sends before it waits to be asked again."""


class Op(enum.IntEnum):
    """Opcodes."""

    NONE = 0
    TERMINATE = 1
    RESET = 2
    LIST = 3
    OPEN_READ = 4
    READ = 5
    CREATE = 6
    WRITE = 7
    REMOVE = 8
    CREATE_DIRECTORY = 9
    REMOVE_DIRECTORY = 10
    OPEN_WRITE = 11
    TRUNCATE = 12
    RENAME = 13
    CHECKSUM = 14
    BURST_READ = 15
    ACK = 128
    NAK = 129


class Fault(enum.IntEnum):
    """Why a request is refused."""

    INVALID_SIZE = 3
    INVALID_SESSION = 4
    NO_SESSION_LEFT = 5
    END = 6
    UNKNOWN = 7
    PROTECTED = 9
    NOT_FOUND = 10


WRITES = {
    Op.CREATE, Op.WRITE, Op.REMOVE, Op.CREATE_DIRECTORY, Op.REMOVE_DIRECTORY, Op.OPEN_WRITE, Op.TRUNCATE, Op.RENAME,
}  # fmt: skip


class FileLink:
    """One link's side, of the vehicle with system id ``system``. One file is open at a time, as in PX4. ``logs``: path
    -> what has been written of it until now."""

    def __init__(
        self, system: int, logs: Mapping[str, bytearray], send: Callable[[Format, tuple[Value, ...]], None]
    ) -> None:
        self._system, self._logs, self._send = system, logs, send
        self._open: bytes | bytearray | None = None
        self._last: tuple[bytes, tuple[Value, ...]] | None = None

    def request(self, frame: Frame) -> None:
        """A FILE_TRANSFER_PROTOCOL. One that is sent again is answered again."""
        said = frame.format.named(frame.values)
        if said["target_system"] not in (0, self._system) or said["target_component"] not in (0, 1):
            return
        payload = bytes(said["payload"])
        if self._last is not None and self._last[0] == payload:
            self._send(FTP, self._last[1])
            return
        sequence, session, code, size, _, _, _, offset = HEADER.unpack_from(payload)
        if code >= Op.ACK:
            return
        to = (frame.system, frame.component)
        if size > DATA:
            self._answer(to, payload, sequence, session, code, offset, Fault.INVALID_SIZE)
            return
        data = payload[HEADER.size : HEADER.size + size]
        if code == Op.BURST_READ:
            self._burst(to, payload, sequence, session, offset, size or DATA)
            return
        self._answer(to, payload, sequence, session, code, offset, self._execute(code, session, offset, size, data))

    def _execute(self, code: int, session: int, offset: int, size: int, data: bytes) -> bytes | Fault:
        """The data of the answer, or why there is none."""
        path = data.split(b"\0")[0].decode("utf-8", "replace").strip("/")
        if code in (Op.NONE, Op.RESET):
            self._open = None if code == Op.RESET else self._open
            return b""
        if code == Op.LIST:
            sizes = {name: len(file.data) for name, file in FILES.items()}
            return _list_directory(path, offset, sizes | {name: len(data) for name, data in self._logs.items()})
        if code in (Op.OPEN_READ, Op.CHECKSUM):
            content = self._logs.get(path) if path in self._logs else FILES[path].data if path in FILES else None
            if content is None:
                return Fault.NOT_FOUND
            if code == Op.CHECKSUM:
                return struct.pack("<I", zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF)
            if self._open is not None:
                return Fault.NO_SESSION_LEFT
            self._open = content
            return struct.pack("<I", len(content))
        if code in (Op.READ, Op.TERMINATE):
            if self._open is None or session != 0:
                return Fault.INVALID_SESSION
            if code == Op.TERMINATE:
                self._open = None
                return b""
            return bytes(self._open[offset : offset + min(size or DATA, DATA)]) or Fault.END
        return Fault.PROTECTED if code in WRITES else Fault.UNKNOWN

    def _burst(self, to: tuple[int, int], asked: bytes, sequence: int, session: int, offset: int, size: int) -> None:
        if self._open is None or session != 0:
            self._answer(to, asked, sequence, session, Op.BURST_READ, offset, Fault.INVALID_SESSION)
            return
        for number in range(BURST):
            part = bytes(self._open[offset : offset + min(size, DATA)])
            last = number == BURST - 1 and bool(part)
            self._answer(to, asked, sequence + number, session, Op.BURST_READ, offset, part or Fault.END, last)
            if not part:
                return
            offset += len(part)

    def _answer(
        self, to: tuple[int, int], asked: bytes, sequence: int, session: int, code: int, offset: int,
        done: bytes | Fault, burst_complete: bool = False,
    ) -> None:  # fmt: skip
        good = not isinstance(done, Fault)
        data = bytes([done.value]) if isinstance(done, Fault) else done
        head = HEADER.pack(
            sequence + 1 & 0xFFFF, session, Op.ACK if good else Op.NAK, len(data), code, burst_complete, 0, offset
        )  # fmt: skip
        payload = (head + data).ljust(PAYLOAD, b"\0")
        values = FTP.values(target_network=0, target_system=to[0], target_component=to[1], payload=tuple(payload))
        self._last = (asked, values)
        self._send(FTP, values)


def _list_directory(path: str, offset: int, sizes: Mapping[str, int]) -> bytes | Fault:
    """The entries of a directory from number ``offset`` on, as many as fit. ``sizes``: path -> bytes of every file."""
    folders = DIRECTORIES | {str(folder) for name in sizes for folder in PurePosixPath(name).parents} - {"."}
    if path not in folders:
        return Fault.NOT_FOUND
    under = f"{path}/" if path else ""
    entries = [f"D{name[len(under) :]}\0".encode() for name in sorted(folders) if _lies_in(name, under)]
    entries += [
        f"F{name[len(under) :]}\t{size}\0".encode() for name, size in sorted(sizes.items()) if _lies_in(name, under)
    ]
    found = b""
    for entry in entries[offset:]:
        if len(found) + len(entry) > DATA:
            break
        found += entry
    return found or Fault.END


def _lies_in(name: str, under: str) -> bool:
    rest = name.removeprefix(under)
    return name.startswith(under) and rest != "" and "/" not in rest
