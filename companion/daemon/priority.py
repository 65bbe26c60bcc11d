"""What of a batch of datagrams must be taken in before the newest state in it is acted on."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from companion.mavlink.codec import MAGIC_V2
from companion.mavlink.telemetry import ODOMETRY

STATE_ID = ODOMETRY.id.to_bytes(3, "little")


def parted(batch: Sequence[bytes], wanted: Collection[int] | None) -> tuple[list[bytes], list[bytes]]:
    """(now, later), each in the order of arrival. What came after the newest state can wait, and so can a message that
    nobody reads: it only goes to the record. An acknowledgement or a change of mode before it never waits."""
    for i in range(len(batch), 0, -1):
        if batch[i - 1][7:10] == STATE_ID:
            break
    else:
        return list(batch), []
    now: list[bytes] = []
    later: list[bytes] = []
    for data in batch[:i]:
        (later if wanted is not None and _is_one_of_others(data, wanted) else now).append(data)
    later += batch[i:]
    return now, later


def _is_one_of_others(data: bytes, wanted: Collection[int]) -> bool:
    """Whether a datagram is one whole frame that nobody reads."""
    if len(data) < 12 or data[0] != MAGIC_V2 or data[2] or data[1] + 12 != len(data):
        return False
    return data[7] | data[8] << 8 | data[9] << 16 not in wanted
