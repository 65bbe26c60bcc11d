"""``link.xrce``: every datagram of PX4's XRCE client and its agent, both ways; and what it shows of a flight.

Each record is the time as a big-endian count of microseconds since 1970, the direction (0 from PX4, 1 to PX4), the
datagram's length (u16, big endian) and the datagram.
"""

from __future__ import annotations

import math
import struct
from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from companion.record.growing import GrowingFile
from companion.record.table import Table
from companion.xrce import wire
from companion.xrce.agent import Agent, Sample
from companion.xrce.objects import Data
from companion.xrce.topics import LAYOUTS

NAME = "link.xrce"
DATAGRAMS_WAITING = 30_000
"""Datagrams that wait for the disk at most, about half a minute (engineering choice)."""
CLOCK_OVER = 1.0
"""s over which PX4's clock is compared with ours."""
STAMP_MAX = 10**13
"""us since boot, a third of a year. PX4 adds its clock's offset to every stamp, also to one that is 0."""
_HEAD = struct.Struct(">QBH")
_STAMP = struct.Struct("<Q")
SENT = {"actuator_motors": ("control", 4), "vehicle_torque_setpoint": ("xyz", 3)}
"""The topics that carry a setpoint: their field and how many of its values are the columns ``sent_0`` and on."""


class XrceWriter(GrowingFile):
    """Writes datagrams. ``epoch``: s since 1970 at which our monotonic clock read zero."""

    def __init__(self, directory: Path, epoch: float) -> None:
        super().__init__(directory / NAME, DATAGRAMS_WAITING)
        self._epoch = epoch

    def add_datagram(self, now: float, to_px4: bool, data: bytes) -> None:
        """Take one that came or went at ``now``."""
        self.append(_HEAD.pack(round((self._epoch + now) * 1e6), to_px4, len(data)) + data)


class TimedDatagram(NamedTuple):
    """A datagram: s since 1970, whether it went to PX4, its bytes."""

    at: float
    to_px4: bool
    data: bytes


class XrceEvidence(NamedTuple):
    """What ``link.xrce`` shows. ``commands``: setpoints that went out. ``differing``: the first that is not the one of
    its tick, in words. ``latency``: s from a state's stamp to its command, each, by PX4's clock; see ``examined``."""

    commands: int
    differing: str | None
    latency: tuple[float, ...]


def records(data: bytes) -> Iterator[TimedDatagram]:
    """The datagrams of a file's bytes; the last one may be cut short."""
    at = 0
    while at + _HEAD.size <= len(data):
        stamp, way, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        if at + length > len(data):
            return
        yield TimedDatagram(stamp * 1e-6, bool(way), data[at : at + length])
        at += length


def examined(data: bytes, table: Table) -> XrceEvidence:
    """The commands in a file's bytes beside the setpoints of the flight's ticks.

    PX4's clock is known from what it publishes: a sample's stamp is older than its arrival by the way here at least,
    and the least seen within CLOCK_OVER counts, since a simulated clock may fall behind ours. So the latency lacks what
    the quickest datagram took, some tenths of a millisecond.
    """
    setpoints = _setpoints(table)
    agent = Agent()
    clock: deque[tuple[float, float]] = deque()  # when (s), by how much ours was ahead of PX4's: both rising
    offset = 0
    sent: list[tuple[float, int, bool]] = []  # s from stamp to command, the stamp (us), whether it is the tick's
    for at, to_px4, datagram in records(data):
        if not to_px4:
            samples = agent.receive(datagram, at)
            told = _offset(samples)
            offset = offset if told is None else told
            for stamp in _stamps(samples):
                ahead = at - (stamp + offset) * 1e-6
                while clock and clock[-1][1] >= ahead:
                    clock.pop()  # the newer one is less and lasts longer
                clock.append((at, ahead))
            continue
        while clock and at - clock[0][0] > CLOCK_OVER:
            clock.popleft()
        least = clock[0][1] if clock else math.nan
        names = {reader.object: name for name, reader in agent.reading.items()}
        for name, sample in _commands(datagram, names):
            field, count = SENT[name]
            values = LAYOUTS[name, 0].decode(sample)
            if values is not None:
                stamp, command = values["timestamp_sample"], np.float32(values[field][:count])
                sent.append((at - stamp * 1e-6 - least, stamp, command.tobytes() in setpoints.get(stamp, ())))
    wrong = next((f"the command for the state of {stamp * 1e-6:.3f} s" for _, stamp, same in sent if not same), None)
    latency = tuple(took for took, _, _ in sent if math.isfinite(took))
    return XrceEvidence(len(sent), wrong, latency)


def read_latency(directory: Path, table: Table) -> XrceEvidence | None:
    """What a flight folder's ``link.xrce`` shows; None: there is none, or it cannot be read."""
    try:
        return examined((directory / NAME).read_bytes(), table)
    except (OSError, wire.WireError):
        return None


def latency_words(evidence: XrceEvidence) -> str:
    """How long commands took, for people."""
    if not evidence.latency:
        return f"{evidence.commands} commands over XRCE"
    p50, p95, most = (1e3 * float(np.percentile(evidence.latency, share)) for share in (50, 95, 100))
    return (
        f"{evidence.commands} commands over XRCE; from a state's stamp to its command (control latency, PX4's clock) "
        f"{p50:.1f} ms median, {p95:.1f} ms p95, {most:.1f} ms at most"
    )


def _setpoints(table: Table) -> dict[int, set[bytes]]:
    """By the stamp of the state (us), the setpoints of the ticks as PX4's floats."""
    found: dict[int, set[bytes]] = {}
    sends = table["setpoint"] > 0
    rows = table[sends]
    sent = np.stack([rows[f"sent_{i}"] for i in range(4)], axis=1).astype(np.float32)
    stamps = _latest(table["t_boot"])[sends]
    for stamp, values, kind in zip(stamps.tolist(), sent, rows["setpoint"].tolist(), strict=True):
        count = 4 if kind == 1 else 3
        found.setdefault(round(stamp * 1e6), set()).add(values[:count].tobytes())
    return found


def _latest(stamps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each tick's stamp, or where no state came with it, the one before: a setpoint goes out with the last state's
    stamp. 0: none has come yet."""
    known = np.isfinite(stamps)
    last = np.maximum.accumulate(np.where(known, np.arange(len(stamps)), -1))
    return np.where(last < 0, 0.0, stamps[last])


def _offset(samples: Iterable[Sample]) -> int | None:
    """us that PX4 last took from its stamps to have them on the agent's clock, which is its own: half of a round trip.
    None: it has not said."""
    said = [LAYOUTS["timesync_status", 0].decode(each.cdr) for each in samples if each.topic.name == "timesync_status"]
    return next((values["estimated_offset"] for values in reversed(said) if values is not None), None)


def _stamps(samples: Iterable[Sample]) -> Iterator[int]:
    """The stamps (us, PX4's clock) of what PX4 published."""
    for each in samples:
        if len(each.cdr) >= _STAMP.size:
            (stamp,) = _STAMP.unpack_from(each.cdr)
            if 0 < stamp < STAMP_MAX:
                yield stamp


def _commands(datagram: bytes, names: dict[int, str]) -> Iterator[tuple[str, bytes]]:
    """The setpoints in a datagram to PX4."""
    for each in wire.decode(datagram).submessages:
        if isinstance(each, Data) and names.get(each.object) in SENT:
            yield names[each.object], each.sample
