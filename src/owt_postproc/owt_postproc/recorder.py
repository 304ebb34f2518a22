"""Recording a run of the graph: the topics of a case in one bag, in an order that depends on the case alone.

Messages of different topics arrive in an order that varies from run to run. They are held until it is their
turn: what is latched first, then block by block the topics in the order of :func:`owt_ros.topics.recorded`.
Flow control bounds what is held to a few blocks.
"""

from __future__ import annotations

import time
from collections import deque
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message

from owt_model.config import CaseConfig
from owt_model.errors import OwtError, StreamError
from owt_model.structure import case_structure, load_structure
from owt_model.structure_text import structure_text
from owt_model.versions import versions
from owt_postproc.bag import BagWriter
from owt_ros import schema, topics
from owt_ros.cdr import canonical
from owt_ros.selection import Selection
from owt_ros.topics import Kind, Topic, recorded
from owt_ros.vetting import check_model, check_numbers

__all__ = ["Recorder"]

#: Wall time in s after which a recording in real time shows what it has: what a killed one loses at most.
FLUSH_S = 0.5
NEVER_NS = 2**63


class Recorder:
    """One recording.

    Parameters
    ----------
    bag : str
        Folder to record into.
    case : CaseConfig
        Attached to the bag.
    overwrite : bool
        Replace an existing bag when the new one is complete.
    selection : Selection
        What is kept of each message; it knows the reduced model before the first block is written.

    Raises
    ------
    InputError
        If the bag cannot be begun there.
    """

    def __init__(self, bag: str, case: CaseConfig, *, overwrite: bool, selection: Selection) -> None:
        self._selection = selection
        self._model_hash = case_structure(case.structure).content_hash
        self._model_name = case.structure.model
        self._writer = BagWriter(bag, overwrite=overwrite)
        wanted = recorded(case)
        self.counts = {topic.label: 0 for topic in wanted}
        self._held: dict[Topic, deque[tuple[bytes, Any, int]]] = {topic: deque() for topic in wanted}
        self._latched = [topic for topic in wanted if topic.kind is Kind.LATCHED]
        self._blocks = [topic for topic in wanted if topic.kind is Kind.DATA or topic is topics.CLOCK]
        self._turn = 0
        self._ended: set[Topic] = set()
        self._flush_ns = round(FLUSH_S * case.stream.rate * 1e9)
        self._flush_at_ns = 0  # after the first block
        self._last_log_ns, self._clock_ns = 0, -1
        try:
            for topic in wanted:
                name = schema.type_name(topic.message)
                self._writer.add_topic(
                    topic.label,
                    name,
                    schema.definition(name),
                    type_hash=schema.type_hash(name),
                    latched=topic.kind is Kind.LATCHED,
                )
            structure = structure_text(load_structure(case.structure.model))
            self._writer.attach("structure.yaml", "application/yaml", structure.encode())
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

    @property
    def folder(self) -> Path:
        """Where the recording lies now."""
        return self._writer.folder

    @property
    def held(self) -> int:
        """Messages that wait for their turn."""
        return sum(map(len, self._held.values()))

    @property
    def written(self) -> int:
        """Messages in the bag."""
        return sum(self.counts.values()) - self.held

    @property
    def is_complete(self) -> bool:
        """Whether everything that belongs in the bag is in it."""
        return not self._latched and not self.held and all(map(self._has_ended, self._blocks))

    def put(self, topic: Topic, cdr: bytes, *, time_ns: int, last: bool = False) -> None:
        """Take the next message of a topic; `last` ends it.

        Parameters
        ----------
        topic : Topic
            One of the case.
        cdr : bytes
            The message.
        time_ns : int
            Its simulated time.
        last : bool
            Whether no other follows.

        Raises
        ------
        StreamError
            If the bag cannot be written any further, the message cannot be or belongs to another structure,
            a second one comes on a latched topic, or the clock goes back.
        """
        message = deserialize_message(cdr, topic.message)
        self._check(topic, message, time_ns)
        self.counts[topic.label] += 1
        if topic.kind is Kind.EVENT and topic is not topics.CLOCK:
            self._write(topic, cdr, message, time_ns)  # a mark stands where the recording is
            return
        self._held[topic].append((cdr, message, time_ns))
        if last:
            self._ended.add(topic)
        self._write_what_is_due()

    def _check(self, topic: Topic, message: Any, time_ns: int) -> None:
        """Refuse what cannot be, and what only a second producer sends.

        The order of numbered streams is checked where they come in.
        """
        check_numbers(message, topic)
        if hasattr(message, "model_hash"):
            check_model(message, topic, self._model_hash, self._model_name)
        if topic.kind is Kind.LATCHED and self.counts[topic.label]:
            raise StreamError(
                f"a second message on {topic.label}: only one node may publish it, once for each run"
            )
        if topic is topics.CLOCK:
            if time_ns <= self._clock_ns:
                raise StreamError(
                    f"{topic.label} went from {self._clock_ns * 1e-9:.9g} s to {time_ns * 1e-9:.9g} s: only "
                    "one node may publish it"
                )
            self._clock_ns = time_ns

    def _write_what_is_due(self) -> None:
        while self._latched and self._held[self._latched[0]]:
            topic = self._latched.pop(0)
            self._write(topic, *self._held[topic].popleft())
        while not self._latched and self.held:
            topic = self._blocks[self._turn]
            if self._held[topic]:
                self._write(topic, *self._held[topic].popleft())
            elif not self._has_ended(topic):
                return
            self._turn = (self._turn + 1) % len(self._blocks)

    def _has_ended(self, topic: Topic) -> bool:
        """Tell whether the last message of a topic is there; the clock ticks once for each block of loads."""
        if topic is not topics.CLOCK:
            return topic in self._ended
        ticks, blocks = self.counts[topics.CLOCK.label], self.counts[topics.NODAL_LOADS.label]
        return topics.NODAL_LOADS in self._ended and ticks >= blocks

    def _write(self, topic: Topic, cdr: bytes, message: Any, time_ns: int) -> None:
        # Log times increase, so that readers, which sort by them, keep the order of the file.
        self._last_log_ns = max(time.time_ns(), self._last_log_ns + 1)
        kept = canonical(topic.message, self._selection.of(topic, cdr, message))
        self._writer.write(topic.label, kept, log_time_ns=self._last_log_ns, publish_time_ns=time_ns)
        if topic is self._blocks[-1] and time_ns >= self._flush_at_ns:
            self._writer.flush()
            self._flush_at_ns = time_ns + self._flush_ns if self._flush_ns else NEVER_NS

    def flush(self) -> None:
        """Show readers what has been written so far."""
        self._writer.flush()

    def close(self) -> None:
        """Complete the bag and give it its name."""
        self._writer.close()

    def break_off(self) -> None:
        """End a recording that will not be complete: a readable bag under its partial name."""
        try:
            while self.held:
                for topic in self._held:
                    if self._held[topic]:
                        self._write(topic, *self._held[topic].popleft())
            self._writer.seal()
        finally:
            self._writer.abandon()
