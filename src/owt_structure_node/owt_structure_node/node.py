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
from owt_ros import convert, decode, topics
from owt_ros.lifecycle import StageNode
from owt_ros.live import LiveInput
from owt_ros.process import interruptible, run
from owt_ros.topics import Topic
from owt_ros.vetting import check_model
from owt_structure_node.core.stage import ResponseModel, build_response_model, initial_state, step
from owt_structure_node.kernels import warm_up
from owt_structure_node.wind_source import tower_top_load, wrench_samples

__all__ = ["StructureNode", "main"]


class StructureNode(StageNode):
    """Builds the reduced model when the load basis arrives, and integrates block by block."""

    ROLE = topics.STRUCTURE

    def configure(self, case: CaseConfig) -> None:
        """Read the structure."""
        self._case = case
        warm_up()  # while nothing waits
        self._mesh = build_mesh(case_structure(case.structure))
        self._model_hash = self._mesh.structure.content_hash
        self._queue: deque[LoadBlock] = deque()
        self._model: ResponseModel | None = None
        self._reduced = self.outlet(topics.REDUCED_MODEL)
        self._top = tower_top_load(case, self._mesh, live=True)
        self._top_out = None if self._top is None else self.outlet(topics.TOWER_TOP_LOAD)
        self._live = self._listen(case)
        self._modal = self.outlet(topics.MODAL_STATE)
        self._stress = self.outlet(topics.MEMBER_STRESS)
        self._energy = self.outlet(topics.ENERGY)
        self.inlet(topics.MODEL, self._on_model)
        self.inlet(topics.LOAD_BASIS, self._on_basis)
        self._loads = self.inlet(topics.NODAL_LOADS, self._on_loads)

    def _listen(self, case: CaseConfig) -> LiveInput | None:
        """Take the load at the tower top from outside where the case says so."""
        if case.wind is None or case.wind.topic is None:
            return None
        self._wrench = wrench_samples(case.wind.topic)
        return LiveInput(
            self,
            topics.TOWER_TOP_WRENCH,
            key="wind.topic",
            options=case.wind.topic,
            rate=case.stream.rate,
            samples=self._wrench.buffer,
            receive=lambda message: self._wrench.add(*decode.to_wrench(message)),
            waiting=lambda: f"block {self._queue[0].sequence}" if self._queue else "",
        )

    def announce(self) -> None:
        """Watch over what comes from outside while the node is active."""
        if self._live is not None:
            self._live.start()

    def _tower_top(self, load: LoadBlock) -> WrenchBlock | None:
        """Load at the tower top that goes with a block of wave loads; made up where it has to be."""
        if self._live is None:
            return None if self._top is None else self._top.block(load)
        forced = not self._wrench.reach(load)
        wrench = self._wrench.block(load, forced=forced)
        self._live.taken(forced=forced)
        return wrench

    def _is_ready(self, load: LoadBlock) -> bool:
        """Tell whether the load at the tower top reaches as far as a block of wave loads, or need not."""
        return self._live is None or self._live.may_take(known=self._wrench.reach(load), time_ns=load.time_ns)

    def _check_model(self, message: Any, topic: Topic) -> None:
        check_model(message, topic, self._model_hash, self._case.structure.model)

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
            if not self._is_ready(self._queue[0]):
                return
            load = self._queue.popleft()
            self.time_ns = load.time_ns
            wrench = self._tower_top(load)
            with interruptible():
                self._state, response = step(self._model, self._state, load, wrench)
            if self._top_out is not None and wrench is not None:
                self._top_out.send(convert.tower_top_load_message(wrench))
            self._stress.send(convert.stress_message(response.stress))
            self._modal.send(convert.modal_message(response.modal))
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
