"""What the postproc node writes: a bag of the graph's topics, from serialised messages."""

from __future__ import annotations

import time
from pathlib import Path

from owt_model.config import CaseConfig
from owt_model.errors import OwtError
from owt_model.versions import versions
from owt_postproc.bag import BagWriter
from owt_ros import schema
from owt_ros.topics import Kind, Topic, recorded

__all__ = ["Recorder"]


class Recorder:
    """A bag with the topics of the graph; everything has its name in the bag from the start.

    Parameters
    ----------
    bag : str
        Folder to record into.
    case : CaseConfig
        Attached to the bag.
    overwrite : bool
        Replace an existing bag when the new one is complete.

    Raises
    ------
    InputError
        If the bag cannot be begun there.
    """

    def __init__(self, bag: str, case: CaseConfig, *, overwrite: bool) -> None:
        self._writer = BagWriter(bag, overwrite=overwrite)
        self.counts = {topic.label: 0 for topic in recorded(case)}
        try:
            for topic in recorded(case):
                name = schema.type_name(topic.message)
                self._writer.add_topic(
                    topic.label,
                    name,
                    schema.definition(name),
                    type_hash=schema.type_hash(name),
                    latched=topic.kind is Kind.LATCHED,
                )
            text = case.model_dump_json(indent=1) + "\n"
            self._writer.attach("case.json", "application/json", text.encode())
            self._writer.add_metadata("versions", versions())
        except OwtError:
            self._writer.abandon()
            raise

    @property
    def path(self) -> Path:
        """Name of the bag once it is complete."""
        return self._writer.path

    def write(self, topic: Topic, cdr: bytes, *, time_ns: int) -> None:
        """Append a serialised message of simulated time `time_ns`, as received now.

        Raises
        ------
        ComputationError
            If the bag cannot be written any further.
        """
        self._writer.write(topic.label, cdr, log_time_ns=time.time_ns(), publish_time_ns=time_ns)
        self.counts[topic.label] += 1

    def close(self) -> None:
        """Complete the bag and give it its name."""
        self._writer.close()

    def break_off(self) -> None:
        """End a recording that will not be complete: a readable bag under its partial name."""
        try:
            self._writer.seal()
        finally:
            self._writer.abandon()
