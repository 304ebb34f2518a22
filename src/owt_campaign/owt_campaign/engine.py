"""One load case as fast as it can be, for campaigns: the numbers of the pipeline without blocks and report.

Cases on one structure share a :class:`~owt_campaign.shared_model.SharedModel`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.clusters import (
    CLUSTERS,
    cluster_basis,
    cluster_label,
    cluster_part,
    clusters,
    join_cluster,
)
from owt_campaign.kept_series import SeriesKeeper
from owt_campaign.pipeline import StageClock
from owt_campaign.shared_model import (
    SharedModel,
    case_load_basis,
    case_response,
    check_key,
    model_key,
    prepare_model,
)
from owt_model.config import CaseConfig
from owt_model.contracts import LoadRows
from owt_model.errors import InputError
from owt_postproc.core import stage as fatigue_stage
from owt_postproc.core.stage import FatigueResult
from owt_structure_node.core.pieces import Piece, Pieces, PieceState
from owt_structure_node.core.response_model import ResponseModel
from owt_structure_node.core.tower_top import TowerTopLoad
from owt_structure_node.wind_source import tower_top_load
from owt_wave_node.core.stage import WaveStage
from owt_wave_node.sea_source import resolve_case

__all__ = [
    "CLUSTERS",
    "CaseOutcome",
    "EnergyStatistics",
    "SharedModel",
    "cluster_basis",
    "cluster_label",
    "cluster_part",
    "clusters",
    "evaluate_case",
    "join_cluster",
    "model_key",
    "prepare_model",
]

#: Load samples worked on at a time: what is held of them stays in the last level of the cache.
PIECE = 200

#: Potential and kinetic energies of the total and of the substructures.
Energies = tuple[Float[np.ndarray, "row part"], Float[np.ndarray, "row part"]]


@dataclass(frozen=True)
class EnergyStatistics:
    """Mean and standard deviation in J over the record of the energies of the whole and of its parts.

    Attributes
    ----------
    part : tuple of str
        "total", then the substructures, which add up to it at every instant.
    potential_mean, potential_std, kinetic_mean, kinetic_std : float arrays [part]
    """

    part: tuple[str, ...]
    potential_mean: Float[np.ndarray, " part"]
    potential_std: Float[np.ndarray, " part"]
    kinetic_mean: Float[np.ndarray, " part"]
    kinetic_std: Float[np.ndarray, " part"]


@dataclass(frozen=True)
class CaseOutcome:
    """What one case gave.

    Attributes
    ----------
    case : CaseConfig
        As computed: a sea that came from a file is one of components.
    fatigue : FatigueResult
        Damage and cycles of the hot spots, total stress of the member ends.
    energy : EnergyStatistics
    stage_seconds : dict
        Seconds spent in each stage.
    series : dict of arrays
        What was asked to be kept, by the name that it was asked by.
    reduction, notes : str, tuple of str
        The reduction in use, and what is to be said of it and of the hot spots.
    """

    case: CaseConfig
    fatigue: FatigueResult
    energy: EnergyStatistics
    stage_seconds: dict[str, float]
    series: dict[str, np.ndarray]
    reduction: str = ""
    notes: tuple[str, ...] = ()


def evaluate_case(
    case: CaseConfig, model: SharedModel | None = None, *, keep: Iterable[str] = ()
) -> CaseOutcome:
    """Evaluate one case from the sea to the damage.

    Parameters
    ----------
    case : CaseConfig
        The case.
    model : SharedModel, optional
        From :func:`prepare_model` of a case of the same :func:`model_key`; prepared here where left out.
    keep : iterable of str
        Series to keep, as :mod:`owt_campaign.kept_series` names them.

    Raises
    ------
    InputError
        If the case is refused, does not share the model, or a series is not known.
    ComputationError
        If a result cannot be trusted.
    """
    clock = StageClock()
    case = resolve_case(case)
    if case.live is not None:
        raise InputError(
            "live", "given", "is read by the running graph only", "Leave it out for the waves of sea_state."
        )
    if model is None:
        model = prepare_model(case)
        clock.lap("model")
    check_key(model, case)
    tower_top = tower_top_load(case, model.mesh)
    clock.lap("tower-top load")
    wave = WaveStage(case, model.mesh, hydro=model.hydro)
    wave.history()
    clock.lap("waves and loads")
    basis = case_load_basis(model, case, wave)
    clock.lap("load basis")
    response = case_response(model, case, basis, tower_top)
    clock.lap("reduction")
    keeper = SeriesKeeper(keep, model.mesh, response)
    energies: list[Energies] = []
    fatigue_state = fatigue_stage.initial_state(model.fatigue)
    for piece in _pieces(wave, response, tower_top, keeper, clock):
        energies.append(_energies(piece))
        fatigue_state = fatigue_stage.count_rows(model.fatigue, fatigue_state, piece.stress)
        clock.lap("rainflow")
    return CaseOutcome(
        case=case,
        fatigue=fatigue_stage.final(model.fatigue, fatigue_state),
        energy=_statistics(response.description.substructure_name, energies),
        stage_seconds=clock.seconds,
        series=keeper.series(),
        reduction=response.description.reduction,
        notes=(*response.description.notes, *model.fatigue.hot_spots.notes),
    )


def _pieces(
    wave: WaveStage,
    response: ResponseModel,
    tower_top: TowerTopLoad | None,
    keeper: SeriesKeeper,
    clock: StageClock,
) -> Iterator[Piece]:
    """Response piece by piece, a window of the loads at a time."""
    pieces: Pieces | None = None
    state: PieceState | None = None
    for window in range(len(wave.windows)):
        clock.start()
        loads = wave.load_rows(window, PIECE)
        keeper.add_surface(wave, window)
        for load in loads:
            clock.lap("waves and loads")
            if pieces is None:
                pieces = Pieces(response, load)
            state, piece = pieces.step(state, load, _wrench(tower_top, load))
            keeper.add(load, piece)
            clock.lap("response and stress")
            yield piece
            clock.start()


def _wrench(tower_top: TowerTopLoad | None, load: LoadRows) -> Float[np.ndarray, "sample 6"] | None:
    """Samples of the tower-top load that go with a piece of wave loads."""
    if tower_top is None:
        return None
    return tower_top.samples(load.start, load.start + load.nodal.shape[2])


def _energies(piece: Piece) -> Energies:
    """Potential and kinetic energies of the total, then of the substructures."""
    return (
        np.column_stack([piece.potential, piece.potential_substructure]),
        np.column_stack([piece.kinetic, piece.kinetic_substructure]),
    )


def _statistics(names: tuple[str, ...], energies: list[Energies]) -> EnergyStatistics:
    """Statistics over all pieces."""
    potential, kinetic = (np.concatenate(column) for column in zip(*energies, strict=True))
    return EnergyStatistics(
        ("total", *names),
        potential.mean(axis=0), potential.std(axis=0), kinetic.mean(axis=0), kinetic.std(axis=0),
    )  # fmt: skip
