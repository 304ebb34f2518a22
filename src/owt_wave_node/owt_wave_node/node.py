"""The wave node: model, sea state and load basis once, then waves and loads block by block."""

from __future__ import annotations

import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rosgraph_msgs.msg import Clock

from owt_model.config import CaseConfig
from owt_model.mesh import build_mesh
from owt_model.reduction_name import parse_reduction
from owt_model.structure import case_structure
from owt_ros import convert, decode, topics
from owt_ros.convert import stamp
from owt_ros.lifecycle import StageNode
from owt_ros.live import LiveInput
from owt_ros.pace import Pace
from owt_ros.process import interruptible, run
from owt_wave_node.core.live import LiveStage, case_stage
from owt_wave_node.core.stage import WaveStage
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
            self._stage: LiveStage | WaveStage = case_stage(case, mesh)
            basis = self._stage.load_basis(parse_reduction(case.structure.reduction).load_vectors)
        self._latched = [
            (self.outlet(topics.MODEL), convert.model_message(mesh)),
            (self.outlet(topics.SEA_STATE), convert.sea_state_message(self._stage.sea_state)),
            (self.outlet(topics.LOAD_BASIS), convert.load_basis_message(basis)),
        ]
        self._time = self.outlet(topics.CLOCK)
        self._elevation = self.outlet(topics.SURFACE_ELEVATION)
        self._loads = self.outlet(topics.NODAL_LOADS)
        self._live = self._listen(case, self._stage) if isinstance(self._stage, LiveStage) else None
        self._pace = Pace(case.stream.rate)
        self._block_s = case.stream.block * case.time.dt_s
        self._next = 0

    def _listen(self, case: CaseConfig, stage: LiveStage) -> LiveInput:
        """Take the elevation from outside; the record made of it is a stream of its own."""
        assert case.live is not None
        self._used = self.outlet(topics.MEASURED_ELEVATION_USED)
        self._next_record = 0

        def receive(message: Any) -> None:
            time_ns, point = decode.to_point(message)
            stage.add(time_ns, float(point[2]), point[:2])

        return LiveInput(
            self,
            topics.MEASURED_ELEVATION,
            key="live",
            options=case.live,
            rate=case.stream.rate,
            samples=stage.samples,
            receive=receive,
            waiting=lambda: f"block {self._next_record} of the record" if self._is_short(stage) else "",
        )

    def announce(self) -> None:
        """Publish what is latched, once; after a pause go on with the next block."""
        for outlet, message in self._latched:
            outlet.send(message)
        self._latched = []
        self._pace.restart()
        if period := self._pace.period_s(self._block_s):
            self.every(period, self.advance)
        if self._live is not None:
            self._live.start()

    def _is_short(self, stage: LiveStage) -> bool:
        """Tell whether the record has to grow and may."""
        return self._next_record < stage.n_records and self._used.is_open

    def _extend_record(self, stage: LiveStage, live: LiveInput) -> None:
        """Put what has come on the grid, and publish it as it is used."""
        while self._is_short(stage):
            known = stage.reach_record(self._next_record)
            if not live.may_take(known=known, time_ns=stage.record_time_ns(self._next_record)):
                return
            self._used.send(convert.measured_message(stage.record_block(self._next_record, forced=not known)))
            self._next_record += 1
            live.taken(forced=not known)

    def _is_ready(self) -> bool:
        """Tell whether the next block can be computed and is due."""
        if isinstance(self._stage, LiveStage) and not self._stage.reach(self._next):
            return False
        return self._pace.is_due(self._stage.time_ns(self._next))

    def advance(self) -> None:
        """Publish the blocks that are due and that every consumer has room for."""
        if self._live is not None and isinstance(self._stage, LiveStage):
            self._extend_record(self._stage, self._live)
        if self._next == 1 and not (self._elevation.is_open and self._loads.is_open):
            self._pace.restart(0)  # simulated time runs from when everybody has begun
        while self._next < self._stage.n_blocks and self._elevation.is_open and self._loads.is_open:
            if not self._is_ready():
                return
            with interruptible():
                elevation, loads = self._stage.elevation_block(self._next), self._stage.load_block(self._next)
            if isinstance(self._stage, LiveStage) and (note := self._stage.take_note()):
                self.get_logger().warning(note)
                self.diagnose(DiagnosticStatus.WARN, note)
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
