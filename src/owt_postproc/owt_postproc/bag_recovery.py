"""What can be saved of a bag whose recording broke off, or that is damaged."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from mcap.records import Attachment, Channel, Message, Metadata, Schema

from owt_model.errors import InputError
from owt_postproc.bag import METADATA, BagWriter
from owt_postproc.mcap_file import has_footer, scan
from owt_postproc.partial_folder import PartialFolder, partial_path

__all__ = ["Recovery", "find_files", "recover", "recover_report"]


@dataclass(frozen=True)
class Recovery:
    """What was restored.

    Attributes
    ----------
    messages : int
        Messages in the new bag.
    intact : bool
        True if the bag was complete and has been copied.
    damaged : tuple of str
        One line per chunk left out, and for the place where a file breaks off.
    """

    messages: int
    intact: bool
    damaged: tuple[str, ...] = field(default_factory=tuple)


def find_files(bag: Path) -> list[Path]:
    """MCAP files of a bag folder, of its partial folder, or the file itself, in the order of recording.

    Raises
    ------
    InputError
        If there are none.
    """
    if bag.is_file():
        return [bag]
    folder = bag if bag.is_dir() else partial_path(bag.absolute())
    files = sorted(folder.glob("*.mcap"))
    if not files and any(folder.glob("*.db3*")):
        raise InputError(
            "bag",
            str(bag),
            "is an SQLite recording",
            "Convert it: rosbags-convert --src BAG --dst NEW --dst-storage mcap.",
        )
    if not files:
        raise InputError("bag", str(bag), "holds no MCAP file", "Give a bag folder, finished or partial.")
    return files


def recover(bag: str | Path, new: str | Path) -> int:
    """Restore every complete chunk of `bag` into `new`; returns the number of messages.

    Parameters
    ----------
    bag : path
        Bag folder, ``.NAME.partial`` folder, or MCAP file; a NAME that only exists as partial is found.
    new : path
        Bag folder to write. An intact bag is copied, file by file.

    Raises
    ------
    InputError
        If `bag` is not a bag or nothing in it can be read, or `new` exists or cannot be written.
    """
    return recover_report(bag, new).messages


def recover_report(bag: str | Path, new: str | Path) -> Recovery:
    """Like :func:`recover`; returns what was and what was not restored."""
    bag, new = Path(bag), Path(new)
    files = find_files(bag)
    size = sum(file.stat().st_size for file in files)
    folder = files[0].parent
    if not bag.is_file() and (folder / METADATA).is_file():
        messages = _count_if_intact(files)
        if messages is not None:
            _copy(folder, new, size)
            return Recovery(messages, intact=True)
    messages, damaged = 0, list[str]()
    with BagWriter(new, expected_bytes=size) as writer:
        for file in files:
            messages += _restore(file, writer, damaged)
        if not writer.topics or (damaged and messages == 0):
            raise InputError(
                "bag", str(bag), "holds nothing that can be read", "It may not be an MCAP recording."
            )
    return Recovery(messages, intact=False, damaged=tuple(damaged))


def _count_if_intact(files: list[Path]) -> int | None:
    """Messages in `files`, None if anything is missing or damaged."""
    messages = 0
    for file in files:
        damaged: list[str] = []
        with file.open("rb") as stream:
            if not has_footer(stream):
                return None
            messages += sum(isinstance(record, Message) for record in scan(stream, damaged=damaged))
        if damaged:
            return None
    return messages


def _copy(folder: Path, new: Path, size: int) -> None:
    """Copy a bag folder; the copy appears when it is complete."""
    place = PartialFolder(new, expected_bytes=size)
    try:
        shutil.copytree(folder, place.folder, dirs_exist_ok=True)
        place.publish()
    except (OSError, shutil.Error) as error:
        raise place.failure(f"cannot be copied ({error})") from None
    finally:
        place.release()


def _restore(file: Path, writer: BagWriter, damaged: list[str]) -> int:
    """Pass on what `file` holds; returns the number of messages."""
    schemas: dict[int, Schema] = {}
    topics: dict[int, str] = {}
    messages = 0
    with file.open("rb") as stream:
        if not has_footer(stream):
            damaged.append(f"{file.name} was not finished")
        for record in scan(stream, damaged=damaged):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                if record.id not in topics and record.schema_id in schemas:
                    topics[record.id] = _announce(record, schemas[record.schema_id], writer)
            elif isinstance(record, Message):
                if record.channel_id in topics:
                    writer.write(
                        topics[record.channel_id],
                        record.data,
                        log_time_ns=record.log_time,
                        publish_time_ns=record.publish_time,
                        sequence=record.sequence,
                    )
                    messages += 1
            elif isinstance(record, Attachment):
                writer.attach(record.name, record.media_type, record.data, time_ns=record.log_time)
            elif isinstance(record, Metadata) and record.name != "rosbag2":
                writer.add_metadata(record.name, record.metadata)
    return messages


def _announce(channel: Channel, schema: Schema, writer: BagWriter) -> str:
    if channel.topic not in writer.topics:
        writer.add_recorded_topic(
            channel.topic,
            schema.name,
            schema.data,
            schema_encoding=schema.encoding,
            encoding=channel.message_encoding,
            offered_qos=yaml.safe_load(channel.metadata.get("offered_qos_profiles", "")) or [],
            type_hash=channel.metadata.get("topic_type_hash", ""),
        )
    return channel.topic
