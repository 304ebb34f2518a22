"""The structure node: loads in; generalised response, member stress and energy out."""

from __future__ import annotations

import sys
from collections import deque
from typing import Any

from owt_model.config import CaseConfig
from owt_model.contracts import LoadBlock, WrenchBlock
from owt_model.errors import StreamError
from owt_model.mesh import build_mesh
from owt_model.structure import case_structure
from owt_model.wind_config import WrenchTopic
from owt_ros import convert, decode, topics
from owt_ros.lifecycle import StageNode
from owt_ros.pace import Patience
from owt_ros.process import interruptible, run
from owt_ros.topics import Topic
from owt_ros.vetting import check_model
from owt_structure_node.core.stage import ResponseModel, build_response_model, initial_state, step
from owt_structure_node.core.tower_top import WrenchSamples
from owt_structure_node.wind_source import tower_top_load

__all__ = ["StructureNode", "main"]


class StructureNode(StageNode):
    """Builds the reduced model when the load basis arrives, and integrates block by block."""

    ROLE = topics.STRUCTURE

    def configure(self, case: CaseConfig) -> None:
        """Read the structure."""
        self._case = case
        self._mesh = build_mesh(case_structure(case.structure))
        self._queue: deque[LoadBlock] = deque()
        self._model: ResponseModel | None = None
        self._reduced = self.outlet(topics.REDUCED_MODEL)
        self._top = tower_top_load(case, self._mesh, live=True)
        self._top_out = None if self._top is None else self.outlet(topics.TOWER_TOP_LOAD)
        self._wrench = None if case.wind is None or case.wind.topic is None else self._listen(case.wind.topic)
        self._modal = self.outlet(topics.MODAL_STATE)
        self._stress = self.outlet(topics.MEMBER_STRESS)
        self._energy = self.outlet(topics.ENERGY)
        self.inlet(topics.MODEL, self._on_model)
        self.inlet(topics.LOAD_BASIS, self._on_basis)
        self._loads = self.inlet(topics.NODAL_LOADS, self._on_loads)

    def _listen(self, topic: WrenchTopic) -> WrenchSamples:
        """Take the load at the tower top from outside."""
        self.inlet(topics.TOWER_TOP_WRENCH, self._on_wrench)
        self._patience = Patience(topic.timeout_s)
        return WrenchSamples(hold=topic.interpolation == "hold")

    def announce(self) -> None:
        """Watch over what comes from outside while the node is active."""
        if self._wrench is not None:
            self._patience.restart()
            self.every(0.25 * self._patience.limit_s, self._watch)

    def _watch(self) -> None:
        if self._patience.is_over(waiting=not self._next_is_known()):
            raise StreamError(
                f"no message on {topics.TOWER_TOP_WRENCH.label} reaches the end of block "
                f"{self._queue[0].sequence} within {self._patience.limit_s:g} s: publish it, stamped in "
                "simulated time, or raise wind.topic.timeout_s"
            )

    def _next_is_known(self) -> bool:
        """Tell whether the load at the tower top reaches as far as the next block of wave loads."""
        return self._wrench is None or not self._queue or self._wrench.reach(self._queue[0])

    def _tower_top(self, load: LoadBlock) -> WrenchBlock | None:
        if self._wrench is not None:
            return self._wrench.block(load)
        return None if self._top is None else self._top.block(load)

    def _on_wrench(self, message: Any) -> None:
        assert self._wrench is not None
        self._wrench.add(*decode.to_wrench(message))
        self._patience.restart()
        self.advance()

    def _check_model(self, message: Any, topic: Topic) -> None:
        check_model(message, topic, self._mesh.structure, self._case.structure.model)

    def _on_model(self, message: Any) -> None:
        self._check_model(message, topics.MODEL)

    def _on_basis(self, message: Any) -> None:
        self._check_model(message, topics.LOAD_BASIS)
        if self._model is not None:
            raise StreamError("a second load basis arrived: clean up and configure before another sea state")
        with interruptible():
            self._model = build_response_model(
                self._case, self._mesh, decode.to_load_basis(message), self._top
            )
            self._state = initial_state(self._model)
        for note in self._model.description.notes:
            self.get_logger().info(f"note: {note}")
        self._reduced.send(convert.reduced_model_message(self._model.description))
        self.advance()

    def _on_loads(self, message: Any) -> None:
        self._check_model(message, topics.NODAL_LOADS)
        self._queue.append(decode.to_nodal_loads(message))
        self.advance()

    def advance(self) -> None:
        """Integrate the blocks that have arrived, as far as the consumers have room."""
        outlets = [self._modal, self._stress, self._energy]
        outlets += [] if self._top_out is None else [self._top_out]
        while self._model is not None and self._queue and all(outlet.is_open for outlet in outlets):
            if not self._next_is_known():
                return
            load = self._queue.popleft()
            with interruptible():
                wrench = self._tower_top(load)
                self._state, response = step(self._model, self._state, load, wrench)
            if self._top_out is not None and wrench is not None:
                self._top_out.send(convert.tower_top_load_message(wrench))
            self._modal.send(convert.modal_message(response.modal))
            self._stress.send(convert.stress_message(response.stress))
            self._energy.send(convert.energy_message(response.energy))
            self._loads.acknowledge(load.sequence)
            self.report(time_ns=load.time_ns, done="{}" if load.last else None)

    def release(self) -> None:
        """Forget model and state."""
        self._model = self._state = None  # type: ignore[assignment]


def main() -> int:
    """Run the node."""
    return run(StructureNode)


if __name__ == "__main__":
    sys.exit(main())
