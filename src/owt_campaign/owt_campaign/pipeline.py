"""One load case in one process: the same stages, the same blocks and the same numbers as the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from owt_model.config import CaseConfig
from owt_model.contracts import (
    ElevationBlock,
    EnergyBlock,
    FatigueBlock,
    LoadBasis,
    LoadBlock,
    ModalBlock,
    ReducedDescription,
    SeaState,
    StressBlock,
)
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure
from owt_postproc.core import stage as fatigue_stage
from owt_structure_node.core import stage as response_stage
from owt_wave_node.core.stage import WaveStage, build_wave_stage

__all__ = ["CaseBlocks", "CaseRun", "prepare_case", "stream_case"]


@dataclass(frozen=True)
class CaseBlocks:
    """What the graph publishes for one block of load samples."""

    elevation: ElevationBlock
    load: LoadBlock
    modal: ModalBlock
    stress: StressBlock
    energy: EnergyBlock
    fatigue: FatigueBlock


@dataclass
class StageClock:
    """Seconds spent in each stage."""

    seconds: dict[str, float] = field(default_factory=dict)
    _since: float = field(default_factory=time.perf_counter)

    def start(self) -> None:
        """Begin a lap."""
        self._since = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Book the time since the last lap to `stage`."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._since
        self._since = now


@dataclass(frozen=True)
class CaseRun:
    """A prepared case: what the graph latches before its first block."""

    case: CaseConfig
    mesh: Mesh
    wave: WaveStage
    load_basis: LoadBasis
    response: response_stage.ResponseModel
    fatigue: fatigue_stage.FatigueModel
    clock: StageClock

    @property
    def sea_state(self) -> SeaState:
        """The components that drive the case."""
        return self.wave.sea_state

    @property
    def reduced(self) -> ReducedDescription:
        """Names and frequencies of the reduced model."""
        return self.response.description


def prepare_case(case: CaseConfig) -> CaseRun:
    """Build every stage of `case`.

    Raises
    ------
    InputError
        If the case, the structure or their combination is refused.
    """
    clock = StageClock()
    mesh = build_mesh(load_structure(case.structure.model))
    clock.lap("model")
    wave = build_wave_stage(case, mesh)
    clock.lap("waves and loads")
    basis = wave.load_basis(response_stage.n_mta(case.structure.reduction))
    clock.lap("load basis")
    response = response_stage.build_response_model(case, mesh, basis)
    clock.lap("reduction")
    fatigue = fatigue_stage.build_fatigue_model(case, n_ends=2 * mesh.n_members)
    return CaseRun(case, mesh, wave, basis, response, fatigue, clock)


def stream_case(run: CaseRun, *, progress: Callable[[float, float], None] | None = None) -> Iterator[CaseBlocks]:
    """Yield the blocks of a prepared case, in the order and partition of the graph.

    Parameters
    ----------
    run : CaseRun
        From :func:`prepare_case`.
    progress : callable, optional
        Called with the simulated time reached and the duration, in s.
    """
    clock, duration = run.clock, run.case.time.duration_s
    response_state = response_stage.initial_state(run.response)
    fatigue_state = fatigue_stage.initial_state(run.fatigue)
    for i in range(run.wave.n_blocks):
        clock.start()
        elevation, load = run.wave.elevation_block(i), run.wave.load_block(i)
        clock.lap("waves and loads")
        response_state, out = response_stage.step(run.response, response_state, load)
        clock.lap("response and stress")
        fatigue_state, counted = fatigue_stage.step(run.fatigue, fatigue_state, out.stress)
        clock.lap("rainflow")
        yield CaseBlocks(elevation, load, out.modal, out.stress, out.energy, counted)
        if progress is not None:
            progress((load.start + len(load.nodal)) * load.dt, duration)
