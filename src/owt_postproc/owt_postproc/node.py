"""The postproc node: records the graph, counts cycles while the stress arrives, publishes the damage."""

from __future__ import annotations

import json
import sys
from collections import deque
from contextlib import suppress
from functools import partial
from typing import Any, Literal

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
from owt_ros.selection import Selection
from owt_ros.topics import Kind, Topic
from owt_ros.wire import Head, peek_stamp, time_ns

__all__ = ["PostprocNode", "PostprocOptions", "main"]


class PostprocOptions(NodeOptions):
    """Parameters of the postproc node besides the case."""

    bag: str = Field("", description="folder to record into; it gets this name when it is complete")
    overwrite: bool = Field(False, description="replace an existing bag when the new one is complete")
    record: Literal["default", "all"] = Field(
        "default", description="what the bag keeps: what the rest is computed from, or everything"
    )
    record_ends: int = Field(
        8, ge=0, le=100_000, description="member ends, the most used, whose stress the default keeps"
    )


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
        self._selection = Selection(everything=self.options.record == "all", ends=self.options.record_ends)
        self._recorder = Recorder(
            self.options.bag, case, overwrite=self.options.overwrite, selection=self._selection
        )
        self._fatigue = self.outlet(topics.FATIGUE)
        self._streams = {}
        for topic in topics.recorded(case):
            if topic.kind is Kind.LATCHED:
                self.inlet(topic, partial(self._on_latched, topic), raw=True)
            elif topic.kind is Kind.DATA and topic is not topics.FATIGUE:
                self._streams[topic] = self.inlet(topic, partial(self._on_data, topic), raw=True)
        self.inlet(topics.CLOCK, self._on_clock, raw=True)
        self.inlet(topics.DIAGNOSTICS, self._on_diagnostics, raw=True)

    def _record(self, topic: Topic, cdr: bytes, at_ns: int, *, last: bool = False) -> None:
        if self._recorder is not None:
            self._recorder.put(topic, cdr, time_ns=at_ns, last=last)

    def _on_latched(self, topic: Topic, cdr: bytes) -> None:
        if topic is topics.REDUCED_MODEL and self._model is None:
            self._reduced = decode.to_reduced_model(deserialize_message(cdr, ReducedModel))
            self._selection.learn(self._reduced)
            self._model = build_fatigue_model(self._case, n_ends=len(self._reduced.end_name))
            self._state = initial_state(self._model)
        self._record(topic, cdr, 0)
        self.advance()

    def _on_data(self, topic: Topic, head: Head, cdr: bytes) -> None:
        self._record(topic, cdr, head.time_ns, last=head.last)
        if topic is topics.MEMBER_STRESS:
            self._pending.append(cdr)
        else:
            self._streams[topic].acknowledge(head.sequence)
        self.advance()

    def _on_clock(self, cdr: bytes) -> None:
        self._record(topics.CLOCK, cdr, peek_stamp(cdr))
        self.advance()

    def _on_diagnostics(self, cdr: bytes) -> None:
        """Mark in the bag what went wrong elsewhere: an ordinary run has no marks, whatever arrives when."""
        status = deserialize_message(cdr, DiagnosticArray).status
        names = [entry.name for entry in status]
        worst = max((entry.level for entry in status), default=DiagnosticStatus.OK)
        own = any(name.endswith(RATE_SUFFIX) or name.startswith(self.ROLE) for name in names)
        if worst != DiagnosticStatus.OK and not own:
            self._record(topics.DIAGNOSTICS, cdr, peek_stamp(cdr))

    def diagnose(self, level: bytes, message: str, *, suffix: str = "", **values: Any) -> DiagnosticArray:
        """Publish a diagnostic, and record it if it holds no wall time."""
        diagnostic = super().diagnose(level, message, suffix=suffix, **values)
        if suffix != RATE_SUFFIX:
            with suppress(OwtError):
                self._record(topics.DIAGNOSTICS, serialize_message(diagnostic), self.time_ns)
        return diagnostic

    def advance(self) -> None:
        """Count the stress that has arrived; complete the bag after the last message of all streams."""
        while self._model is not None and self._pending:
            stress = decode.to_stress(deserialize_message(self._pending.popleft(), MemberStress))
            with interruptible():
                self._state, block = step(self._model, self._state, stress)
            message = convert.fatigue_message(block)
            self._fatigue.send(message)
            at_ns = time_ns(message.header.stamp)
            self._record(topics.FATIGUE, serialize_message(message), at_ns, last=block.last)
            self._streams[topics.MEMBER_STRESS].acknowledge(stress.sequence)
            self._largest = float(block.damage.max())
            self.report(time_ns=at_ns)
        if self._recorder is not None and self._recorder.is_complete:
            self._finish(self._recorder)

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
