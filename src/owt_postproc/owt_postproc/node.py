"""The postproc node: records the graph, counts cycles while the stress arrives, publishes the damage."""

from __future__ import annotations

import json
import sys
from collections import deque
from contextlib import suppress
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from owt_msgs.msg import MemberStress
from owt_msgs.srv import FatigueSummary, Flush
from rclpy.serialization import deserialize_message, serialize_message

from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError
from owt_postproc.core.running import RunningCount
from owt_postproc.options import PostprocOptions, selection_of
from owt_postproc.recorder import Recorder
from owt_ros import convert, decode, topics
from owt_ros.lifecycle import StageNode
from owt_ros.options import RATE_SUFFIX, is_mark
from owt_ros.process import interruptible, run
from owt_ros.topics import Kind, Topic
from owt_ros.wire import Head, peek_stamp

__all__ = ["PostprocNode", "main"]

UNMARKED = (topics.POSTPROC, topics.VIEWER)  # no marks: own ones are written here, a viewer may come and go


class PostprocNode(StageNode):
    """Writes every message as it came; deserialises only the stress."""

    ROLE = topics.POSTPROC
    OPTIONS = PostprocOptions
    options: PostprocOptions
    _recorder: Recorder | None = None

    def configure(self, case: CaseConfig) -> None:
        """Begin the bag."""
        if not (options := self.options).bag:
            raise InputError("bag", "", "is missing", "Give the folder to record into.")
        self._count = RunningCount(case)  # an unknown curve is refused before anything is recorded
        self._pending, self._streams = deque[bytes](), {}
        self._selection = selection_of(options, case)
        self._recorder = Recorder(options.bag, case, overwrite=options.overwrite, selection=self._selection)
        self._fatigue = self.outlet(topics.FATIGUE)
        handlers: dict[Kind, Any] = {Kind.LATCHED: self._on_latched, Kind.EVENT: self._on_event}
        for topic in topics.recorded(case):
            if topic is not topics.FATIGUE:
                handler = partial(handlers.get(topic.kind, self._on_data), topic)
                self._streams[topic] = self.inlet(topic, handler, raw=True)
        self.serve(FatigueSummary, topics.FATIGUE_SUMMARY, self._summarise)
        self.serve(Flush, topics.FLUSH, self._flush)

    def _record(self, topic: Topic, cdr: bytes, at_ns: int, *, last: bool = False) -> None:
        if self._recorder is not None:
            self._recorder.put(topic, cdr, time_ns=at_ns, last=last)

    def _on_latched(self, topic: Topic, cdr: bytes) -> None:
        if topic is topics.MODEL and not self._count.is_ready:
            self._count.learn(frame=decode.to_frame(deserialize_message(cdr, topic.message)))
        elif topic is topics.REDUCED_MODEL and not self._count.is_ready:
            self._count.learn(reduced=decode.to_reduced_model(deserialize_message(cdr, topic.message)))
            self._selection.learn(self._count.reduced)
        if warnings := self._count.news():
            self.diagnose(DiagnosticStatus.WARN, warnings)
        self._record(topic, cdr, 0)
        self.advance()

    def _on_data(self, topic: Topic, head: Head, cdr: bytes) -> None:
        self._record(topic, cdr, head.time_ns, last=head.last)
        if topic is topics.MEMBER_STRESS:
            self._pending.append(cdr)
        else:
            self._streams[topic].acknowledge(head.sequence)
        self.advance()

    def _on_event(self, topic: Topic, cdr: bytes) -> None:
        self._mark(topic, cdr)
        self.advance()

    def _mark(self, topic: Topic, cdr: bytes) -> None:  # what went wrong elsewhere; an ordinary run has none
        if topic is topics.CLOCK or is_mark(deserialize_message(cdr, DiagnosticArray), but_of=UNMARKED):
            self._record(topic, cdr, peek_stamp(cdr))

    def diagnose(self, level: bytes, message: str, *, suffix: str = "", **values: Any) -> DiagnosticArray:
        """Publish a diagnostic, and record it if it holds no wall time."""
        diagnostic = super().diagnose(level, message, suffix=suffix, **values)
        if suffix != RATE_SUFFIX:
            with suppress(OwtError):
                self._record(topics.DIAGNOSTICS, serialize_message(diagnostic), self.time_ns)
        return diagnostic

    def advance(self) -> None:
        """Count the stress that has arrived; complete the bag after the last message of all streams."""
        while self._count.is_ready and self._pending:
            stress = decode.to_stress(deserialize_message(self._pending.popleft(), MemberStress))
            with interruptible():
                block = self._count.count(stress)
            self._fatigue.send(message := convert.fatigue_message(block))
            self._record(topics.FATIGUE, serialize_message(message), block.time_ns, last=block.last)
            self._streams[topics.MEMBER_STRESS].acknowledge(stress.sequence)
            self._largest = float(block.damage.max())
            self.report(time_ns=block.time_ns)
        if self._recorder is not None and self._recorder.is_complete:
            self._finish(self._recorder)

    def _finish(self, recorder: Recorder) -> None:
        for cdr in self._streams[topics.DIAGNOSTICS].arrived():  # of before the last block, in their queue
            self._mark(topics.DIAGNOSTICS, cdr)
        self.diagnose(DiagnosticStatus.OK, "complete", samples=self._count.samples)
        recorder.close()
        self._recorder = None
        counts = {"largest_damage": self._largest, "stress_samples": self._count.samples}
        self.report(done=json.dumps({"bag": str(recorder.path), "messages": recorder.counts} | counts))

    def _summarise(self, request: Any, response: Any) -> Any:
        """Answer with the fatigue so far."""
        response.summary_json = json.dumps(self._count.summary(), allow_nan=False)
        return response

    def _flush(self, request: Any, response: Any) -> Any:
        """Show readers what has been recorded."""
        try:
            if (recorder := self._recorder) is None:
                raise OwtError("nothing is being recorded")
            recorder.flush()
            response.messages, response.bag, response.success = recorder.written, str(recorder.folder), True
        except OwtError as error:
            response.message = str(error)
        return response

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
