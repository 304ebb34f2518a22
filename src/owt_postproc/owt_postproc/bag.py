"""Recording: rosbag2 folders with one MCAP file, which appear under their name only when complete.

A bag NAME is written as ``.NAME.partial`` beside it. Closing it writes the summary and ``metadata.yaml``,
syncs, and renames; whatever goes wrong before leaves the partial folder and no NAME. Nothing here needs
ROS: messages come as CDR bytes, message definitions as text.
"""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import yaml

from owt_model.errors import ComputationError, InputError
from owt_postproc.mcap_file import ChunkWriter
from owt_postproc.message_schema import type_hash as hash_of
from owt_postproc.partial_folder import PartialFolder, partial_path, sync

__all__ = ["METADATA", "BagWriter", "partial_path"]

METADATA = "metadata.yaml"
#: Version of metadata.yaml that rosbag2 of Jazzy and Kilted writes.
METADATA_VERSION = 9
CHUNK_SIZE = 1 << 20
_FOREVER = {"sec": 9223372036, "nsec": 854775807}


class BagWriter:
    """Writes one bag.

    Used as a context manager it closes the bag at the end of the block, or abandons it on an exception.

    Parameters
    ----------
    path : path
        Folder to write.
    overwrite, expected_bytes
        See :class:`owt_postproc.partial_folder.PartialFolder`.
    ros_distro : str
        What ``metadata.yaml`` names as its origin.
    chunk_size : int
        Uncompressed bytes per chunk: what a killed recording loses at most.

    Raises
    ------
    InputError
        If the bag cannot be begun there.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        overwrite: bool = False,
        expected_bytes: int = 0,
        ros_distro: str = "kilted",
        chunk_size: int = CHUNK_SIZE,
    ) -> None:
        self._place = PartialFolder(path, overwrite=overwrite, expected_bytes=expected_bytes)
        self._ros_distro = ros_distro
        self._topics: dict[str, tuple[int, dict[str, Any]]] = {}
        self._sequence: dict[str, int] = {}
        self._lock = threading.RLock()
        self._sealed = False
        self._fd = -1
        self.file = self.folder / f"{self.path.name}_0.mcap"
        try:
            self._fd = os.open(self.file, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
            self._writer = ChunkWriter(
                self._write_bytes, profile="ros2", library="owt_postproc", chunk_size=chunk_size
            )
        except (OSError, ComputationError) as error:
            self.abandon()
            reason = error.strerror if isinstance(error, OSError) else "no space for its first bytes"
            raise InputError(
                "bag",
                str(self.path),
                f"cannot be written ({reason})",
                "Choose a writable folder with free space.",
            ) from None

    @property
    def path(self) -> Path:
        """Final name of the bag."""
        return self._place.path

    @property
    def folder(self) -> Path:
        """Where the bag lies until it is complete."""
        return self._place.folder

    @property
    def topics(self) -> tuple[str, ...]:
        """Topics announced so far."""
        return tuple(self._topics)

    def _write_bytes(self, data: bytes) -> None:
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._fd, view) :]
        except OSError as error:
            full = error.errno in (errno.ENOSPC, errno.EDQUOT)
            raise self._place.failure("the disk is full" if full else str(error.strerror)) from None

    def add_topic(
        self,
        topic: str,
        type_name: str,
        schema: str,
        *,
        type_hash: str | None = None,
        latched: bool = False,
        depth: int = 10,
    ) -> None:
        """Announce a topic.

        Parameters
        ----------
        topic, type_name : str
            ``/owt/energy``, ``owt_msgs/msg/Energy``.
        schema : str
            Definition of the type, then its nested ones, each after a line of 80 ``=`` and ``MSG: pkg/Name``.
        type_hash : str, optional
            RIHS01 hash; computed from the schema if it is not given.
        latched : bool
            Whether the publisher keeps its last message for late joiners.
        depth : int
            History depth offered by the publisher.
        """
        hashed = type_hash if type_hash is not None else hash_of(type_name, schema)
        qos = {
            "history": "keep_last",
            "depth": depth,
            "reliability": "reliable",
            "durability": "transient_local" if latched else "volatile",
            "deadline": _FOREVER,
            "lifespan": _FOREVER,
            "liveliness": "automatic",
            "liveliness_lease_duration": _FOREVER,
            "avoid_ros_namespace_conventions": False,
        }
        self.add_recorded_topic(topic, type_name, schema.encode(), offered_qos=[qos], type_hash=hashed)

    def add_recorded_topic(
        self,
        topic: str,
        type_name: str,
        schema: bytes,
        *,
        offered_qos: list[dict[str, Any]],
        type_hash: str,
        schema_encoding: str = "ros2msg",
        encoding: str = "cdr",
    ) -> None:
        """Announce a topic as another bag describes it."""
        with self._lock:
            if topic in self._topics:
                raise ValueError(f"topic {topic} is already in the bag")
            number = self._writer.add_schema(type_name, schema_encoding, schema)
            channel = self._writer.add_channel(
                topic,
                number,
                encoding,
                {"offered_qos_profiles": _dump(offered_qos), "topic_type_hash": type_hash},
            )
            description = {
                "name": topic,
                "type": type_name,
                "serialization_format": encoding,
                "offered_qos_profiles": offered_qos,
                "type_description_hash": type_hash,
            }
            self._topics[topic] = channel, description
            self._sequence[topic] = 0

    def write(
        self, topic: str, data: bytes, *, log_time_ns: int, publish_time_ns: int, sequence: int | None = None
    ) -> None:
        """Append a message.

        Parameters
        ----------
        topic : str
            One announced before.
        data : bytes
            The message in CDR, header included.
        log_time_ns : int
            When it was received; orders the bag.
        publish_time_ns : int
            Simulated time of the message.
        sequence : int, optional
            Of the publisher; counted here if it is not given.

        Raises
        ------
        ComputationError
            If the bag cannot be written any further.
        """
        with self._lock:
            channel, _ = self._topics[topic]
            self._writer.add_message(
                channel,
                data,
                log_time=log_time_ns,
                publish_time=publish_time_ns,
                sequence=self._sequence[topic] if sequence is None else sequence,
            )
            self._sequence[topic] += 1

    def attach(self, name: str, media_type: str, data: bytes, *, time_ns: int = 0) -> None:
        """Put a file into the bag (the case, versions)."""
        with self._lock:
            self._writer.add_attachment(name, media_type, data, log_time=time_ns)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Put a table of strings into the bag."""
        with self._lock:
            self._writer.add_metadata(name, values)

    def flush(self) -> None:
        """Write the chunk begun, so that a reader sees what came so far."""
        with self._lock:
            self._writer.finish_chunk()

    def seal(self) -> None:
        """Complete the recording inside :attr:`folder`; other files may be put there before :meth:`close`.

        Raises
        ------
        ComputationError
            If that cannot be done; the partial folder stays.
        """
        with self._lock:
            if self._sealed:
                return
            self._writer.finish_chunk()
            metadata = self._metadata()
            self._writer.add_metadata(
                "rosbag2", {"serialized_metadata": _dump(metadata["rosbag2_bagfile_information"])}
            )
            self._writer.finish()
            try:
                os.fsync(self._fd)
                (self.folder / METADATA).write_text(_dump(metadata), encoding="utf-8")
                sync(self.folder / METADATA)
            except OSError as error:
                raise self._place.failure(f"cannot be completed ({error.strerror})") from None
            self._close_file()
            self._sealed = True

    def close(self) -> None:
        """Complete the bag and give it its name.

        Raises
        ------
        ComputationError
            If that cannot be done; the partial folder stays.
        """
        with self._lock:
            self.seal()
            self._place.publish()

    def abandon(self) -> None:
        """Stop recording; the partial folder keeps every chunk written."""
        with self._lock:
            self._close_file()
            self._place.release()

    def _close_file(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _metadata(self) -> dict[str, Any]:
        """Content of metadata.yaml."""
        counts = self._writer.counts
        start, end = self._writer.span or (0, 0)
        span = {
            "duration": {"nanoseconds": end - start},
            "starting_time": {"nanoseconds_since_epoch": start},
            "message_count": sum(counts.values()),
        }
        return {
            "rosbag2_bagfile_information": {
                "version": METADATA_VERSION,
                "storage_identifier": "mcap",
                **span,
                "topics_with_message_count": [
                    {"topic_metadata": description, "message_count": counts[channel]}
                    for channel, description in self._topics.values()
                ],
                "compression_format": "",
                "compression_mode": "",
                "relative_file_paths": [self.file.name],
                "files": [{"path": self.file.name, **span}],
                "custom_data": None,
                "ros_distro": self._ros_distro,
            }
        }

    def __enter__(self) -> Self:
        """Return the writer."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the bag, or abandon it after an exception."""
        try:
            if kind is None:
                self.close()
        finally:
            self.abandon()


class _Plain(yaml.SafeDumper):
    """Writes repeated values in full: rosbag2's parser knows no anchors."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _dump(data: Any) -> str:
    return yaml.dump(data, Dumper=_Plain, default_flow_style=False, sort_keys=False)
