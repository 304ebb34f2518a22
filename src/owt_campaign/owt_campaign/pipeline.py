"""One load case in one process: the same stages, the same blocks and the same numbers as the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields

import numpy as np
from jaxtyping import Float

from owt_model.config import CaseConfig
from owt_model.contracts import (
    Block,
    ElevationBlock,
    EnergyBlock,
    FatigueBlock,
    LoadBasis,
    LoadBlock,
    ModalBlock,
    StressBlock,
    WrenchBlock,
    sea_facts,
)
from owt_model.errors import InputError
from owt_model.frame import frame_of_mesh
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import Structure, case_structure
from owt_postproc.core import stage as fatigue_stage
from owt_postproc.core.hot_spots import build_hot_spots
from owt_postproc.report_data import ReportCollector, ReportData, mesh_geometry
from owt_structure_node.core import stage as response_stage
from owt_structure_node.core.tower_top import TowerTopLoad
from owt_structure_node.wind_source import tower_top_load
from owt_wave_node.core.live import LiveStage, live_stage_from_record
from owt_wave_node.core.stage import WaveStage, build_wave_stage
from owt_wave_node.sea_source import resolve_case

__all__ = ["CaseBlocks", "CaseResult", "CaseRun", "prepare_case", "run_case", "stream_case"]


@dataclass(frozen=True)
class CaseBlocks:
    """What the graph publishes for one block of load samples.

    ``fatigue_state`` is what the counting carries to the next block.
    """

    elevation: ElevationBlock
    load: LoadBlock
    modal: ModalBlock
    stress: StressBlock
    energy: EnergyBlock
    fatigue: FatigueBlock
    fatigue_state: fatigue_stage.FatigueState
    tower_top: WrenchBlock | None = None

    def streams(self) -> tuple[Block, ...]:
        """The blocks in the order of the chain."""
        top = () if self.tower_top is None else (self.tower_top,)
        return (self.elevation, self.load, *top, self.modal, self.stress, self.energy, self.fatigue)


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
    wave: WaveStage | LiveStage
    load_basis: LoadBasis
    response: response_stage.ResponseModel
    fatigue: fatigue_stage.FatigueModel
    clock: StageClock
    tower_top: TowerTopLoad | None = None


@dataclass(frozen=True)
class CaseResult:
    """What one case gave.

    Attributes
    ----------
    report : ReportData
        Series and fatigue results, as the report shows them.
    mesh : Mesh
        The structure as computed.
    series : dict of arrays
        Every channel of every stream over the whole record, keyed ``stream.channel``; empty unless asked for.
    stage_seconds : dict
        Seconds spent in each stage.
    """

    report: ReportData
    mesh: Mesh
    series: dict[str, np.ndarray]
    stage_seconds: dict[str, float]


def prepare_case(
    case: CaseConfig,
    *,
    measured: Float[np.ndarray, " time"] | None = None,
    tower_top: TowerTopLoad | None = None,
    structure: Structure | None = None,
) -> CaseRun:
    """Build every stage of `case`; a sea in a file becomes one of components in the case that is returned.

    Parameters
    ----------
    case : CaseConfig
        The case.
    measured : float array [time], optional
        Elevation in m of a case with a live elevation, as a graph has used it.
    tower_top : TowerTopLoad, optional
        Load at the tower top in the place of the file or topic that the case names.
    structure : Structure, optional
        In the place of the one that the case names.

    Raises
    ------
    InputError
        If the case, the structure or their combination is refused.
    """
    clock = StageClock()
    case = resolve_case(case)
    mesh = build_mesh(case_structure(case.structure, structure))
    hot_spots = build_hot_spots(frame_of_mesh(mesh), case.fatigue)
    fatigue = fatigue_stage.build_fatigue_model(case, hot_spots)
    clock.lap("model")
    tower_top = tower_top_load(case, mesh) if tower_top is None else tower_top
    clock.lap("tower-top load")
    wave = _wave_stage(case, mesh, measured)
    clock.lap("waves and loads")
    basis = wave.load_basis(response_stage.n_mta(case.structure.reduction))
    clock.lap("load basis")
    response = response_stage.build_response_model(case, mesh, basis, tower_top)
    clock.lap("reduction")
    return CaseRun(case, mesh, wave, basis, response, fatigue, clock, tower_top)


def _wave_stage(
    case: CaseConfig, mesh: Mesh, measured: Float[np.ndarray, " time"] | None
) -> WaveStage | LiveStage:
    """The wave stage of a case, of a record where the elevation was measured."""
    if case.live is None:
        return build_wave_stage(case, mesh)
    if measured is None:
        raise InputError(
            "live",
            "given",
            "is read by the running graph only",
            "Use ./owt demo --case or the nodes, or leave it out for the waves of sea_state.",
        )
    return live_stage_from_record(case, mesh, measured)


def stream_case(
    run: CaseRun, *, progress: Callable[[float, float], None] | None = None
) -> Iterator[CaseBlocks]:
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
        wrench = None if run.tower_top is None else run.tower_top.block(load)
        response_state, out = response_stage.step(run.response, response_state, load, wrench)
        clock.lap("response and stress")
        fatigue_state, counted = fatigue_stage.step(run.fatigue, fatigue_state, out.stress)
        clock.lap("rainflow")
        yield CaseBlocks(elevation, load, out.modal, out.stress, out.energy, counted, fatigue_state, wrench)
        if progress is not None:
            progress((load.start + len(load.nodal)) * load.dt, duration)


def run_case(
    case: CaseConfig,
    *,
    keep_series: bool = False,
    versions: Mapping[str, str] | None = None,
    progress: Callable[[float, float], None] | None = None,
    measured: Float[np.ndarray, " time"] | None = None,
    tower_top: TowerTopLoad | None = None,
    structure: Structure | None = None,
) -> CaseResult:
    """Run one case from the sea to the damage.

    Parameters
    ----------
    case : CaseConfig
        The case.
    keep_series : bool
        Keep every channel of every stream (about 0.6 GB for 600 s of the OC4 jacket).
    versions : mapping, optional
        Provenance for the report.
    progress : callable, optional
        Called with the simulated time reached and the duration, in s.
    measured, tower_top, structure
        See :func:`prepare_case`.

    Raises
    ------
    InputError
        If the case, the structure or their combination is refused.
    ComputationError
        If a result cannot be trusted.
    """
    run = prepare_case(case, measured=measured, tower_top=tower_top, structure=structure)
    collector = ReportCollector(run.response.description.tower_top_coordinate)
    kept: list[CaseBlocks] = []
    state = fatigue_stage.initial_state(run.fatigue)
    for blocks in stream_case(run, progress=progress):
        for block in blocks.streams():
            collector.add(block)
        state = blocks.fatigue_state
        if keep_series:
            kept.append(blocks)
    sea = run.wave.sea_state
    report = collector.finish(
        case=run.case.model_dump(mode="json"),
        reduced=run.response.description,
        fatigue=fatigue_stage.final(run.fatigue, state),
        geometry=mesh_geometry(run.mesh),
        sea_state=sea_facts(sea),
        versions=versions,
    )
    return CaseResult(report, run.mesh, _series(kept), run.clock.seconds)


def _series(kept: list[CaseBlocks]) -> dict[str, np.ndarray]:
    """Join the sampled channels of the kept blocks, except the running fatigue results."""
    series: dict[str, np.ndarray] = {}
    for stream in ("elevation", "load", "tower_top", "modal", "stress", "energy"):
        blocks = [part for block in kept if (part := getattr(block, stream)) is not None]
        for channel in fields(blocks[0]) if blocks else ():
            values = [getattr(block, channel.name) for block in blocks]
            if not isinstance(values[0], np.ndarray):
                continue
            constant = channel.name in ("gauge", "node", "element")
            series[f"{stream}.{channel.name}"] = values[0] if constant else np.concatenate(values)
    return series
