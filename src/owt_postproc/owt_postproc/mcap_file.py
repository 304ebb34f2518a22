"""MCAP files chunk by chunk: a writer, and a scan that reads damaged files as far as they go.

The record layouts come from the mcap library, whose own writer offers no choice of the compression level.
Schemas and channels stand outside the chunks and are written at once, so that a file that breaks off, or
one damaged chunk, costs no more than its own messages. https://mcap.dev/spec
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import BinaryIO

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader, breakup_chunk

__all__ = ["ChunkWriter", "has_footer", "scan"]

MAGIC = b"\x89MCAP0\r\n"
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_MESSAGE_FIXED = _MESSAGE.size - 9
#: float64 hardly compresses: a low level is several times faster and loses next to nothing.
ZSTD_LEVEL = 1


def _record(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


@dataclass
class _OpenChunk:
    """Records of the chunk being filled."""

    parts: list[bytes] = field(default_factory=list)
    size: int = 0
    messages: int = 0
    start: int = 0
    end: int = 0
    index: dict[int, list[tuple[int, int]]] = field(default_factory=dict)

    def add(self, *parts: bytes) -> None:
        self.parts.extend(parts)
        self.size += sum(map(len, parts))

    def add_message(self, channel: int, log_time: int) -> None:
        self.index.setdefault(channel, []).append((log_time, self.size))
        self.start = min(self.start, log_time) if self.messages else log_time
        self.end = max(self.end, log_time) if self.messages else log_time
        self.messages += 1


class ChunkWriter:
    """Writes an MCAP file of zstd chunks.

    Parameters
    ----------
    write : callable
        Writes bytes to the end of the file, all of them or raises.
    chunk_size : int
        Uncompressed bytes after which a chunk is written.
    """

    def __init__(
        self, write: Callable[[bytes], None], *, profile: str, library: str, chunk_size: int
    ) -> None:
        self._write_bytes, self._chunk_size, self._offset = write, chunk_size, 0
        self._compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunk = _OpenChunk()
        self._chunk_indexes: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        self._span: tuple[int, int] | None = None
        self._write(MAGIC + _record(Header(profile=profile, library=library)))

    @property
    def counts(self) -> dict[int, int]:
        """Messages per channel."""
        return dict(self._counts)

    @property
    def span(self) -> tuple[int, int] | None:
        """First and last log time in ns, None without messages."""
        return self._span

    def _write(self, data: bytes) -> None:
        self._write_bytes(data)
        self._offset += len(data)

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Register a schema; returns its number."""
        schema = Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data)
        self._schemas.append(schema)
        self._write(_record(schema))
        return schema.id

    def add_channel(self, topic: str, schema: int, encoding: str, metadata: dict[str, str]) -> int:
        """Register a channel; returns its number."""
        number = len(self._channels) + 1
        channel = Channel(
            id=number, topic=topic, message_encoding=encoding, metadata=metadata, schema_id=schema
        )
        self._channels.append(channel)
        self._counts[number] = 0
        self._write(_record(channel))
        return number

    def add_message(
        self, channel: int, data: bytes, *, log_time: int, publish_time: int, sequence: int
    ) -> None:
        """Append a message; times in ns."""
        self._chunk.add_message(channel, log_time)
        head = _MESSAGE.pack(
            Opcode.MESSAGE, _MESSAGE_FIXED + len(data), channel, sequence & 0xFFFFFFFF, log_time, publish_time
        )
        self._chunk.add(head, data)
        self._counts[channel] += 1
        first, last = self._span or (log_time, log_time)
        self._span = min(first, log_time), max(last, log_time)
        if self._chunk.size >= self._chunk_size:
            self.finish_chunk()

    def finish_chunk(self) -> None:
        """Write the chunk begun, if it holds any message."""
        chunk = self._chunk
        if not chunk.messages:
            return
        self._chunk = _OpenChunk()
        data = b"".join(chunk.parts)
        packed = self._compressor.compress(data)
        record = _record(
            Chunk(
                compression="zstd",
                data=packed,
                message_end_time=chunk.end,
                message_start_time=chunk.start,
                uncompressed_crc=zlib.crc32(data),
                uncompressed_size=len(data),
            )
        )
        start = self._offset
        offset, offsets, indexes = start + len(record), {}, []
        for channel, entries in chunk.index.items():
            offsets[channel] = offset
            indexes.append(_record(MessageIndex(channel_id=channel, records=entries)))
            offset += len(indexes[-1])
        self._write(b"".join((record, *indexes)))
        self._chunk_indexes.append(
            ChunkIndex(
                chunk_length=len(record),
                chunk_start_offset=start,
                compression="zstd",
                compressed_size=len(packed),
                message_end_time=chunk.end,
                message_index_length=offset - start - len(record),
                message_index_offsets=offsets,
                message_start_time=chunk.start,
                uncompressed_size=len(data),
            )
        )

    def add_attachment(self, name: str, media_type: str, data: bytes, *, log_time: int) -> None:
        """Write an attachment."""
        record = _record(
            Attachment(create_time=log_time, log_time=log_time, name=name, media_type=media_type, data=data)
        )
        self._attachments.append(
            AttachmentIndex(
                offset=self._offset,
                length=len(record),
                log_time=log_time,
                create_time=log_time,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )
        self._write(record)

    def add_metadata(self, name: str, data: dict[str, str]) -> None:
        """Write a metadata record."""
        record = _record(Metadata(name=name, metadata=data))
        self._metadata.append(MetadataIndex(offset=self._offset, length=len(record), name=name))
        self._write(record)

    def finish(self) -> None:
        """Write the last chunk, the summary and the footer."""
        self.finish_chunk()
        self._write(_record(DataEnd(0)))
        start = self._offset
        first, last = self._span or (0, 0)
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self.counts,
            chunk_count=len(self._chunk_indexes),
            message_count=sum(self._counts.values()),
            message_end_time=last,
            message_start_time=first,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        groups: tuple[tuple[Opcode, list[McapRecord]], ...] = (
            (Opcode.SCHEMA, [*self._schemas]),
            (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, [*self._chunk_indexes]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachments]),
            (Opcode.METADATA_INDEX, [*self._metadata]),
        )
        summary, offsets = b"", []
        for opcode, records in groups:
            group = b"".join(map(_record, records))
            if group:
                offsets.append(
                    SummaryOffset(
                        group_opcode=opcode, group_start=start + len(summary), group_length=len(group)
                    )
                )
                summary += group
        offset_start = start + len(summary)
        summary += b"".join(map(_record, offsets))
        crc = zlib.crc32(summary + struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start))
        self._write(
            summary + _record(Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=crc))
        )
        self._write(MAGIC)


def has_footer(stream: BinaryIO) -> bool:
    """Whether the file ends as a finished MCAP file does."""
    size = stream.seek(0, 2)
    if size < 2 * len(MAGIC):
        return False
    stream.seek(-len(MAGIC), 2)
    return stream.read() == MAGIC


def scan(stream: BinaryIO, *, damaged: list[str]) -> Iterator[McapRecord]:
    """Yield schemas, channels, messages, attachments and metadata in file order, as far as they can be read.

    Parameters
    ----------
    stream : binary file
        Open for reading.
    damaged : list of str
        Receives a line per chunk that had to be left out, and one where the file breaks off.
    """
    size = stream.seek(0, 2)
    stream.seek(0)
    records = StreamReader(stream, emit_chunks=True, record_size_limit=size).records
    while True:
        try:
            record = next(records, None)
        except (McapError, EOFError, ValueError, struct.error, UnicodeDecodeError) as error:
            damaged.append(f"the file breaks off near byte {stream.tell()} ({type(error).__name__})")
            return
        if record is None:
            return
        if isinstance(record, Chunk):
            try:
                yield from breakup_chunk(record, validate_crc=True)
            except (McapError, EOFError, ValueError, struct.error, zstandard.ZstdError) as error:
                damaged.append(f"a chunk of {len(record.data)} bytes is damaged ({type(error).__name__})")
        elif isinstance(record, Schema | Channel | Message | Attachment | Metadata):
            yield record
