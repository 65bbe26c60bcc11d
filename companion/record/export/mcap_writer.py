"""An MCAP file of messages that are all there at once. mcap's own writer takes them one by one, which would be most of
an export's time; the records around them are the library's."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from typing import Any, BinaryIO

import numpy as np
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from companion.record.export.channels import Channel

CHUNK_SIZE = 1 << 20
"""bytes of messages that are compressed at once: as mcap's own writer has it."""
MAGIC = b"\x89MCAP0\r\n"
HEAD = np.dtype(
    [("opcode", "u1"), ("size", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("at", "<u8"), ("published", "<u8")]
)
"""Of a message's record, packed; its data follows."""
BEFORE_SIZE = 9
"""bytes of a record that its size does not count: the opcode and the size."""


def write_channels(out: BinaryIO, channels: Sequence[Channel], about: Mapping[str, Mapping[str, str]]) -> int:
    """Write a file: the messages of ``channels`` in the order of time, and what the file is ``about`` as metadata; how
    many messages."""
    schemas = [Schema(i, channel.text, "jsonschema", channel.schema) for i, channel in enumerate(channels, 1)]
    named = [records.Channel(i, channel.topic, "json", {}, i) for i, channel in enumerate(channels, 1)]
    heads, data = _messages(channels)
    out.write(MAGIC + _bytes([Header("", "companion")]))
    chunks = list(_write_chunks(out, heads, data, _bytes([*schemas, *named])))
    metadata = []
    for name, words in about.items():
        record = _bytes([Metadata(name, dict(words))])
        metadata.append(MetadataIndex(out.tell(), len(record), name))
        out.write(record)
    out.write(_bytes([DataEnd(0)]))
    counts = {i: len(channel.data) for i, channel in enumerate(channels, 1) if len(channel.data)}
    first, last = (int(heads["at"][0]), int(heads["at"][-1])) if len(heads) else (0, 0)
    statistics = Statistics(0, len(named), counts, len(chunks), len(heads), last, first, len(metadata), len(schemas))
    _write_summary(out, [schemas, named, [statistics], chunks, metadata])
    return len(heads)


def _messages(channels: Sequence[Channel]) -> tuple[NDArray[np.void], list[bytes]]:
    """The head and the data of every message, in the order of time."""
    data = [each for channel in channels for each in channel.data]
    heads = np.zeros(len(data), HEAD)
    heads["opcode"] = Opcode.MESSAGE
    heads["size"] = HEAD.itemsize - BEFORE_SIZE + np.fromiter(map(len, data), int, len(data))
    heads["channel"] = np.repeat(np.arange(1, len(channels) + 1), [len(channel.data) for channel in channels])
    heads["at"] = heads["published"] = np.concatenate([channel.times for channel in channels])
    order = np.argsort(heads["at"], kind="stable")
    return heads[order], [data[i] for i in order.tolist()]


def _write_chunks(out: BinaryIO, heads: NDArray[np.void], data: Sequence[bytes], before: bytes) -> Iterable[ChunkIndex]:
    """Write the messages, ``before`` them what they are; an index of each chunk."""
    sizes = heads["size"].astype(np.int64) + BEFORE_SIZE
    begins = len(before) + np.cumsum(sizes) - sizes
    firsts = np.flatnonzero(np.diff(begins // CHUNK_SIZE, prepend=-1)).tolist()
    raw, width = heads.tobytes(), HEAD.itemsize
    for first, end in zip(firsts, [*firsts[1:], len(heads)], strict=True):
        pieces = [before]
        for i in range(first, end):
            pieces += (raw[i * width : (i + 1) * width], data[i])
        whole = b"".join(pieces)
        packed = zstandard.compress(whole)
        times = heads["at"][first:end]
        start, stop = int(times[0]), int(times[-1])
        at = out.tell()
        out.write(_bytes([Chunk("zstd", packed, stop, start, zlib.crc32(whole), len(whole))]))
        index = out.tell()
        offsets = len(before) + begins[first:end] - begins[first]
        places = _write_message_index(out, heads["channel"][first:end], times, offsets)
        length = out.tell() - index
        yield ChunkIndex(index - at, at, "zstd", len(packed), stop, length, places, start, len(whole))
        before = b""


def _write_message_index(
    out: BinaryIO, channels: NDArray[Any], times: NDArray[Any], offsets: NDArray[Any]
) -> dict[int, int]:
    """Write where in a chunk each channel's messages are; where that stands in the file."""
    places = {}
    for channel in np.unique(channels).tolist():
        its = channels == channel
        entries = np.column_stack([times[its], offsets[its]]).astype("<u8").tobytes()
        builder = RecordBuilder()
        builder.start_record(Opcode.MESSAGE_INDEX)
        builder.write2(channel)
        builder.write4(len(entries))
        builder.write(entries)
        builder.finish_record()  # type: ignore[no-untyped-call]
        places[channel] = out.tell()
        out.write(builder.end())  # type: ignore[no-untyped-call]
    return places


def _write_summary(out: BinaryIO, groups: Sequence[Sequence[McapRecord]]) -> None:
    """Write all of it once more that a reader wants first, where each kind begins, and the end of the file."""
    start = out.tell()
    summary, offsets = BytesIO(), []
    for group in groups:
        text = _bytes(group)
        if group:
            offsets.append(SummaryOffset(text[0], start + summary.tell(), len(text)))
        summary.write(text)
    offset_start = start + summary.tell()
    summary.write(_bytes(offsets))
    footer = _bytes([Footer(start, offset_start, 0)])
    crc = zlib.crc32(footer[:-4], zlib.crc32(summary.getvalue()))
    out.write(summary.getvalue() + _bytes([Footer(start, offset_start, crc)]) + MAGIC)


def _bytes(written: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in written:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
