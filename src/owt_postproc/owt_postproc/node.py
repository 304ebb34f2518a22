"""The postproc node: records the graph, counts cycles while the stress arrives, publishes the damage."""

from __future__ import annotations

import json
import sys
from collections import deque
from contextlib import suppress
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from owt_msgs.msg import MemberStress, ReducedModel
from pydantic import Field
from rclpy.serialization import deserialize_message, serialize_message

from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError
from owt_postproc.core.sn import sn_curve
from owt_postproc.core.stage import FatigueModel, build_fatigue_model, initial_state, step
from owt_postproc.recorder import Recorder
from owt_ros import convert, decode, topics
from owt_ros.lifecycle import RATE_SUFFIX, NodeOptions, StageNode
from owt_ros.process import interruptible, run
from owt_ros.topics import Kind, Topic
from owt_ros.wire import Head, peek_stamp, time_ns

__all__ = ["PostprocNode", "PostprocOptions", "main"]


class PostprocOptions(NodeOptions):
    """Parameters of the postproc node besides the case."""

    bag: str = Field("", description="folder to record into; it gets this name when it is complete")
    overwrite: bool = Field(False, description="replace an existing bag when the new one is complete")


class PostprocNode(StageNode):
    """Writes every message as it came; deserialises only the stress."""

    ROLE = topics.POSTPROC
    OPTIONS = PostprocOptions
    options: PostprocOptions
    _recorder: Recorder | None = None

    def configure(self, case: CaseConfig) -> None:
        """Begin the bag."""
        if not self.options.bag:
            raise InputError("bag", "", "is missing", "Give the folder to record into.")
        sn_curve(case.fatigue.sn_curve)  # an unknown curve is refused before anything is recorded
        self._case = case
        self._model: FatigueModel | None = None
        self._pending: deque[bytes] = deque()
        self._recorder = Recorder(self.options.bag, case, overwrite=self.options.overwrite)
        self._fatigue = self.outlet(topics.FATIGUE)
        self._streams = {}
        for topic in topics.recorded(case):
            if topic.kind is Kind.LATCHED:
                self.inlet(topic, partial(self._on_latched, topic), raw=True)
            elif topic.kind is Kind.DATA and topic is not topics.FATIGUE:
                self._streams[topic] = self.inlet(topic, partial(self._on_data, topic), raw=True)
        self.inlet(topics.CLOCK, self._on_clock, raw=True)
        self.inlet(topics.DIAGNOSTICS, self._on_diagnostics, raw=True)

    def _write(self, topic: Topic, cdr: bytes, at_ns: int) -> None:
        if self._recorder is not None:
            self._recorder.write(topic, cdr, time_ns=at_ns)

    def _on_latched(self, topic: Topic, cdr: bytes) -> None:
        self._write(topic, cdr, 0)
        if topic is topics.REDUCED_MODEL and self._model is None:
            ends = len(deserialize_message(cdr, ReducedModel).end_name)
            self._model = build_fatigue_model(self._case, n_ends=ends)
            self._state = initial_state(self._model)
        self.advance()

    def _on_data(self, topic: Topic, head: Head, cdr: bytes) -> None:
        self._write(topic, cdr, head.time_ns)
        if topic is topics.MEMBER_STRESS:
            self._pending.append(cdr)
        else:
            self._streams[topic].acknowledge(head.sequence)
        self.advance()

    def _on_clock(self, cdr: bytes) -> None:
        self._write(topics.CLOCK, cdr, peek_stamp(cdr))
        self.advance()

    def _on_diagnostics(self, cdr: bytes) -> None:
        names = [status.name for status in deserialize_message(cdr, DiagnosticArray).status]
        foreign = (self.ROLE, topics.VIEWER)
        if not any(name.endswith(RATE_SUFFIX) or name.startswith(foreign) for name in names):
            self._write(topics.DIAGNOSTICS, cdr, peek_stamp(cdr))

    def diagnose(self, level: bytes, message: str, *, suffix: str = "", **values: Any) -> DiagnosticArray:
        """Publish a diagnostic, and record it if it holds no wall time."""
        diagnostic = super().diagnose(level, message, suffix=suffix, **values)
        if suffix != RATE_SUFFIX:
            with suppress(OwtError):
                self._write(topics.DIAGNOSTICS, serialize_message(diagnostic), self.time_ns)
        return diagnostic

    def advance(self) -> None:
        """Count the stress that has arrived; complete the bag after the last message of all streams."""
        while self._model is not None and self._pending:
            stress = decode.to_stress(deserialize_message(self._pending.popleft(), MemberStress))
            with interruptible():
                self._state, block = step(self._model, self._state, stress)
            message = convert.fatigue_message(block)
            self._fatigue.send(message)
            self._write(topics.FATIGUE, serialize_message(message), time_ns(message.header.stamp))
            self._streams[topics.MEMBER_STRESS].acknowledge(stress.sequence)
            self._largest = float(block.damage.max())
            self.report(time_ns=time_ns(message.header.stamp))
        if self._recorder is not None and self._is_complete(self._recorder.counts):
            self._finish(self._recorder)

    def _is_complete(self, counts: dict[str, int]) -> bool:
        """Tell whether everything that belongs in the bag has arrived."""
        ended = all(inlet.guard.finished for inlet in self._streams.values()) and not self._pending
        latched = all(counts[topic.label] for topic in topics.RECORDED if topic.kind is Kind.LATCHED)
        return ended and latched and counts[topics.CLOCK.label] >= counts[topics.NODAL_LOADS.label]

    def _finish(self, recorder: Recorder) -> None:
        self.diagnose(DiagnosticStatus.OK, "complete", samples=self._state.samples)
        recorder.close()
        self._recorder = None
        result = {
            "bag": str(recorder.path),
            "stress_samples": self._state.samples,
            "largest_damage": self._largest,
            "messages": recorder.counts,
        }
        self.report(done=json.dumps(result))

    def release(self) -> None:
        """End an incomplete recording."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            recorder.break_off()


def main() -> int:
    """Run the node."""
    return run(PostprocNode)


if __name__ == "__main__":
    sys.exit(main())
