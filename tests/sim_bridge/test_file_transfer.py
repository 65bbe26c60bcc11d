"""Files over MAVLink, as ground stations read a vehicle's description of itself."""

from __future__ import annotations

import json
import lzma
import struct
from typing import Any

import pytest

from sim_bridge.autopilot.logger.logger import Logger
from sim_bridge.autopilot.mavlink.file_link import DATA, HEADER, Fault, Op
from tests.support.plant_client import ACCEPTED, Client


class Reader:
    """The other side of FTP."""

    def __init__(self) -> None:
        self.client = Client("sih")
        self.sequence = 0

    def ask(self, code: Op, data: bytes = b"", offset: int = 0, session: int = 0) -> Any:
        """(opcode, data, offset) of each answer."""
        before = len(self.client.all("FILE_TRANSFER_PROTOCOL"))
        head = HEADER.pack(self.sequence, session, code, len(data), 0, 0, 0, offset)
        self.sequence += 2
        self.client.send("FILE_TRANSFER_PROTOCOL", payload=tuple((head + data).ljust(251, b"\0")))
        found = []
        for fields in self.client.all("FILE_TRANSFER_PROTOCOL")[before:]:
            payload = bytes(fields["payload"])
            _, _, answer, size, _, _, _, at = HEADER.unpack_from(payload)
            found.append((answer, payload[HEADER.size : HEADER.size + size], at))
        return found


def test_the_description_of_itself_is_found_and_read() -> None:
    reader = Reader()
    assert reader.client.command(512, 397) == ACCEPTED
    uri = reader.client.last("COMPONENT_METADATA")["uri"]
    path = uri.removeprefix("mftp://").encode()
    ((code, data, _),) = reader.ask(Op.OPEN_READ, path)
    assert code == Op.ACK
    (size,) = struct.unpack("<I", data)
    content = b""
    while len(content) < size:
        ((_, part, _),) = reader.ask(Op.READ, bytes(DATA), offset=len(content))
        content += part
    assert reader.ask(Op.READ, bytes(DATA), offset=size)[0][:2] == (Op.NAK, bytes([Fault.END]))
    assert reader.ask(Op.TERMINATE)[0][0] == Op.ACK
    described = json.loads(lzma.decompress(content))
    assert described["metadataTypes"][0]["uri"].endswith("parameters.json.xz")


def test_a_burst_sends_all_of_it() -> None:
    reader = Reader()
    ((_, data, _),) = reader.ask(Op.OPEN_READ, b"etc/extras/parameters.json.xz")
    (size,) = struct.unpack("<I", data)
    content: dict[int, bytes] = {}
    while sum(map(len, content.values())) < size:
        for code, part, offset in reader.ask(Op.BURST_READ, bytes(DATA), offset=sum(map(len, content.values()))):
            if code == Op.ACK:
                content[offset] = part
    whole = b"".join(content[offset] for offset in sorted(content))
    assert len(json.loads(lzma.decompress(whole))["parameters"]) > 800


def test_directories() -> None:
    reader = Reader()
    assert reader.ask(Op.LIST, b"/")[0][:2] == (Op.ACK, b"Detc\0Dlog\0")
    assert b"Fcomponent_general.json.xz\t" in reader.ask(Op.LIST, b"/etc/extras")[0][1]
    assert reader.ask(Op.LIST, b"/log")[0][:2] == (Op.NAK, bytes([Fault.END]))


def test_the_vehicles_own_log_is_there_after_a_flight() -> None:
    reader = Reader()
    logger = Logger(reader.client.bridge.autopilot)
    for _ in range(250):  # --hover: armed from the start
        reader.client.step()
        logger.step()
    assert reader.ask(Op.LIST, b"/log")[0][:2] == (Op.ACK, b"D2026-01-01\0")
    ((_, listed, _),) = reader.ask(Op.LIST, b"/log/2026-01-01")
    name, size = listed[1:].rstrip(b"\0").split(b"\t")
    reader.client.bridge.autopilot.commander.armed = False
    logger.step()
    reader.client.step()
    logger.step()
    ((_, told, _),) = reader.ask(Op.OPEN_READ, b"/log/2026-01-01/" + name)
    assert struct.unpack("<I", told) == (int(size),)
    ((_, head, _),) = reader.ask(Op.READ, bytes(DATA))
    assert head.startswith(b"ULog\x01\x12\x35\x01") and b"float[3] xyz" in head
    rows = 50 * (8 + 8 + 12 + 5)
    assert rows < int(size) < 8 * rows


@pytest.mark.parametrize(
    ("code", "data", "fault"),
    [
        (Op.OPEN_READ, b"nothing", Fault.NOT_FOUND), (Op.LIST, b"nowhere", Fault.NOT_FOUND),
        (Op.READ, b"", Fault.INVALID_SESSION), (Op.BURST_READ, b"", Fault.INVALID_SESSION),
        (Op.WRITE, b"x", Fault.PROTECTED), (Op.REMOVE, b"etc", Fault.PROTECTED), (77, b"", Fault.UNKNOWN),
    ],
)  # fmt: skip
def test_what_is_refused(code: Op, data: bytes, fault: Fault) -> None:
    assert Reader().ask(code, data)[0][:2] == (Op.NAK, bytes([fault]))
