"""The wave node: model, sea state and load basis once, then waves and loads block by block."""

from __future__ import annotations

import sys

from rosgraph_msgs.msg import Clock

from owt_model.config import CaseConfig
from owt_model.mesh import build_mesh
from owt_model.reduction_name import parse_reduction
from owt_model.structure import case_structure
from owt_ros import convert, topics
from owt_ros.convert import stamp
from owt_ros.lifecycle import StageNode
from owt_ros.pace import Pace
from owt_ros.process import interruptible, run
from owt_wave_node.core.stage import build_wave_stage
from owt_wave_node.sea_source import resolve_case

__all__ = ["WaveNode", "main"]


class WaveNode(StageNode):
    """Computes waves and loads when configured, and streams them while active."""

    ROLE = topics.WAVE

    def configure(self, case: CaseConfig) -> None:
        """Compute the record."""
        with interruptible():
            case = resolve_case(case)
            mesh = build_mesh(case_structure(case.structure))
            self._stage = build_wave_stage(case, mesh)
            basis = self._stage.load_basis(parse_reduction(case.structure.reduction).load_vectors)
        self._latched = [
            (self.outlet(topics.MODEL), convert.model_message(mesh)),
            (self.outlet(topics.SEA_STATE), convert.sea_state_message(self._stage.sea_state)),
            (self.outlet(topics.LOAD_BASIS), convert.load_basis_message(basis)),
        ]
        self._time = self.outlet(topics.CLOCK)
        self._elevation = self.outlet(topics.SURFACE_ELEVATION)
        self._loads = self.outlet(topics.NODAL_LOADS)
        self._pace = Pace(case.stream.rate)
        self._block_s = case.stream.block * case.time.dt_s
        self._next = 0

    def announce(self) -> None:
        """Publish what is latched, once; after a pause go on with the next block."""
        for outlet, message in self._latched:
            outlet.send(message)
        self._latched = []
        self._pace.restart()
        if period := self._pace.period_s(self._block_s):
            self.every(period, self.advance)

    def advance(self) -> None:
        """Publish the blocks that are due and that every consumer has room for."""
        while self._next < self._stage.n_blocks and self._elevation.is_open and self._loads.is_open:
            with interruptible():
                elevation, loads = self._stage.elevation_block(self._next), self._stage.load_block(self._next)
            if not self._pace.is_due(loads.time_ns):
                return
            self._time.send(Clock(clock=stamp(loads.time_ns)))
            self._elevation.send(convert.elevation_message(elevation))
            self._loads.send(convert.nodal_loads_message(loads))
            self._next += 1
            self.report(time_ns=loads.time_ns, done="{}" if loads.last else None)

    def release(self) -> None:
        """Forget the record."""
        self._latched, self._stage = [], None  # type: ignore[assignment]


def main() -> int:
    """Run the node."""
    return run(WaveNode)


if __name__ == "__main__":
    sys.exit(main())
