"""What of a batch of datagrams must be taken in before the newest state in it is acted on."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from companion.mavlink.codec import MAGIC_V2
from companion.mavlink.peer import Received, Source
from companion.mavlink.signing import SIGNATURE_SIZE, SIGNED
from companion.mavlink.telemetry import ODOMETRY

STATE_ID = ODOMETRY.id.to_bytes(3, "little")
"""ODOMETRY's message id as it stands in a MAVLink 2 header."""


def split_by_priority(
    batch: Sequence[Received], wanted: Collection[int] | None, vehicle: Source | None
) -> tuple[list[Received], list[Received]]:
    """(now, later), each in the order of arrival. What came after the newest state can wait, and so can a message that
    nobody reads, which only goes to the record, and what does not come from the ``vehicle``'s source. An
    acknowledgement or a change of mode before it never waits."""
    for i in range(len(batch), 0, -1):
        data, source = batch[i - 1]
        if data[7:10] == STATE_ID and source == vehicle:
            break
    else:
        return list(batch), []
    now: list[Received] = []
    later: list[Received] = []
    for received in batch[:i]:
        data, source = received
        waits = source != vehicle or (wanted is not None and _is_one_of_others(data, wanted))
        (later if waits else now).append(received)
    later += batch[i:]
    return now, later


def _is_one_of_others(data: bytes, wanted: Collection[int]) -> bool:
    """Whether a datagram is one whole frame that nobody reads."""
    if len(data) < 12 or data[0] != MAGIC_V2:
        return False
    rest = 12 if not data[2] else 12 + SIGNATURE_SIZE if data[2] == SIGNED else 0
    if data[1] + rest != len(data):
        return False
    return data[7] | data[8] << 8 | data[9] << 16 not in wanted
