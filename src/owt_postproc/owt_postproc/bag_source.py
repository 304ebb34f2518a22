"""What lies in a bag, as bytes: topics, messages, files; complete, broken off, or still being written.

A complete bag is read by its index, in the order of the log time. One without a footer is read from the front
as far as it goes, in the order of the file; what is appended after it was opened is not looked at.
"""

from __future__ import annotations

import heapq
import io
import json
import os
import struct
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO, Self, cast

import yaml
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Message, Metadata, Schema

from owt_model.errors import InputError
from owt_postproc.bag import METADATA
from owt_postproc.bag_recovery import find_files
from owt_postproc.mcap_file import has_footer, scan

__all__ = ["BagFiles", "BagSource", "RawMessage", "RecordedTopic"]

#: What reading a damaged file can raise.
DAMAGE = (McapError, OSError, EOFError, ValueError, LookupError, TypeError, struct.error, yaml.YAMLError)
#: How rosbag2 writes that a publisher keeps its last message; the number is that of older versions.
LATCHED = ("transient_local", 1)


@dataclass(frozen=True)
class BagFiles:
    """What was put into a bag beside its messages."""

    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)

    @property
    def case(self) -> dict[str, Any]:
        """The case that made the bag, empty if it holds none."""
        return dict(json.loads(self.attachments["case.json"])) if "case.json" in self.attachments else {}


@dataclass(frozen=True)
class RecordedTopic:
    """A topic as a bag describes it.

    Attributes
    ----------
    schema : str
        Definition of its type, nested ones appended.
    qos : mapping
        The first profile that was offered; empty if none is known.
    type_hash : str
        RIHS01 hash of its type; empty if none is known.
    """

    name: str
    type_name: str
    schema: str
    qos: Mapping[str, Any]
    type_hash: str = ""

    @property
    def latched(self) -> bool:
        """Whether its publisher keeps the last message for late joiners."""
        return self.qos.get("durability") in LATCHED


@dataclass(frozen=True)
class RawMessage:
    """One message as recorded; times in ns."""

    topic: str
    type_name: str
    log_time_ns: int
    publish_time_ns: int
    data: bytes


@dataclass
class _Survey:
    """What one pass over files without a footer finds."""

    topics: dict[str, RecordedTopic] = field(default_factory=dict)
    files: BagFiles = field(default_factory=BagFiles)
    damaged: list[str] = field(default_factory=list)


class _Window(io.RawIOBase):
    """The first `size` bytes of an open file, with a position of its own."""

    def __init__(self, fd: int, size: int) -> None:
        self._fd, self._size, self._position = fd, size, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        data = os.pread(self._fd, max(0, min(len(buffer), self._size - self._position)), self._position)
        buffer[: len(data)] = data
        self._position += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = 0, /) -> int:
        self._position = offset + (0, self._position, self._size)[whence]
        return self._position

    def tell(self) -> int:
        return self._position


class BagSource:
    """An open bag; a context manager.

    Parameters
    ----------
    bag : path
        Bag folder, ``.NAME.partial`` folder, or MCAP file; a NAME that only exists as partial is found.

    Raises
    ------
    InputError
        If it holds no MCAP file, or one that cannot be opened.
    """

    def __init__(self, bag: str | Path) -> None:
        self.path = Path(bag)
        self._stack = ExitStack()
        self._open: list[tuple[int, int]] = []
        with self._readable(), ExitStack() as failed:
            failed.callback(self.close)
            try:
                self._open_files()
            except FileNotFoundError:  # the recording was completed, and renamed, in this very moment
                self._open_files()
            self._refuse_compressed()
            self.finished = all(has_footer(stream) for stream in self._streams())
            failed.pop_all()

    def _open_files(self) -> None:
        files = find_files(self.path)
        self.folder = files[0].parent
        with ExitStack() as opened:
            handles = [opened.enter_context(file.open("rb", buffering=0)) for file in files]
            self._open = [(handle.fileno(), os.fstat(handle.fileno()).st_size) for handle in handles]
            self._stack.push(opened.pop_all())

    def _refuse_compressed(self) -> None:
        """Refuse what rosbag2 compressed message by message: the bytes are not those of the messages then."""
        metadata = self.folder / METADATA
        if self.path.is_file() or not metadata.is_file():
            return
        data = yaml.safe_load(metadata.read_text(encoding="utf-8"))
        mode = data["rosbag2_bagfile_information"].get("compression_mode", "")
        if str(mode).lower() not in ("", "none"):
            raise InputError(
                "bag",
                str(self.path),
                f"is compressed by {str(mode).lower()}",
                "Convert it: rosbags-convert --src BAG --dst NEW --dst-storage mcap.",
            )

    def _streams(self) -> list[BinaryIO]:
        return [cast("BinaryIO", io.BufferedReader(_Window(fd, size), 1 << 20)) for fd, size in self._open]

    @contextmanager
    def _readable(self) -> Iterator[None]:
        """Turn what reading a damaged file raises into one clear error."""
        try:
            yield
        except InputError:
            raise
        except DAMAGE as error:
            reason = " ".join(str(error).split()) or type(error).__name__
            raise InputError(
                "bag", str(self.path), f"cannot be read ({reason})", "Try to recover it first."
            ) from None

    @cached_property
    def topics(self) -> dict[str, RecordedTopic]:
        """Topics by name.

        Raises
        ------
        InputError
            If the bag is damaged.
        """
        if not self.finished:
            return self._survey.topics
        found: dict[str, RecordedTopic] = {}
        with self._readable():
            for stream in self._streams():
                summary = make_reader(stream).get_summary()
                if summary is None:
                    return self._survey.topics
                for channel in summary.channels.values():
                    found.setdefault(channel.topic, _topic(channel, summary.schemas.get(channel.schema_id)))
        return found

    @cached_property
    def files(self) -> BagFiles:
        """Attachments and metadata records.

        Raises
        ------
        InputError
            If the bag is damaged.
        """
        if not self.finished:
            return self._survey.files
        files = BagFiles()
        with self._readable():
            for stream in self._streams():
                reader = make_reader(stream)
                files.attachments.update({item.name: item.data for item in reader.iter_attachments()})
                files.metadata.update({item.name: dict(item.metadata) for item in reader.iter_metadata()})
        return files

    @property
    def damaged(self) -> list[str]:
        """One line per chunk that an unfinished bag cannot give; a complete one raises instead."""
        return [] if self.finished else [line for line in self._survey.damaged if "breaks off" not in line]

    @cached_property
    def _survey(self) -> _Survey:
        found = _Survey()
        schemas: dict[int, Schema] = {}
        for stream in self._streams():
            for record in scan(stream, damaged=found.damaged):
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    found.topics.setdefault(record.topic, _topic(record, schemas.get(record.schema_id)))
                elif isinstance(record, Attachment):
                    found.files.attachments[record.name] = record.data
                elif isinstance(record, Metadata):
                    found.files.metadata[record.name] = dict(record.metadata)
        return found

    def messages(self, topics: Collection[str] | None = None) -> Iterator[RawMessage]:
        """Yield the messages in the order of their recording.

        Parameters
        ----------
        topics : collection of str, optional
            Names of those wanted; all by default.

        Raises
        ------
        InputError
            If a complete bag is damaged.
        """
        wanted = None if topics is None else set(topics)
        read = self._indexed if self.finished else self._scanned
        with self._readable():
            found = [read(stream, wanted) for stream in self._streams()]
            yield from (
                heapq.merge(*found, key=lambda message: message.log_time_ns)
                if self.finished
                else (message for file in found for message in file)
            )

    def _indexed(self, stream: BinaryIO, topics: set[str] | None) -> Iterator[RawMessage]:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages(topics):
            yield _message(channel, schema, message)

    def _scanned(self, stream: BinaryIO, topics: set[str] | None) -> Iterator[RawMessage]:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        for record in scan(stream, damaged=[]):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message) and record.channel_id in channels:
                channel = channels[record.channel_id]
                if topics is None or channel.topic in topics:
                    yield _message(channel, schemas.get(channel.schema_id), record)

    def close(self) -> None:
        """Close its files."""
        self._stack.close()

    def __enter__(self) -> Self:
        """Return the source."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close its files."""
        self.close()


def _topic(channel: Channel, schema: Schema | None) -> RecordedTopic:
    profiles = yaml.safe_load(channel.metadata.get("offered_qos_profiles", "")) or [{}]
    text = "" if schema is None else schema.data.decode()
    name, hashed = "" if schema is None else schema.name, channel.metadata.get("topic_type_hash", "")
    return RecordedTopic(channel.topic, name, text, profiles[0], hashed)


def _message(channel: Channel, schema: Schema | None, message: Message) -> RawMessage:
    return RawMessage(
        channel.topic,
        "" if schema is None else schema.name,
        message.log_time,
        message.publish_time,
        message.data,
    )
