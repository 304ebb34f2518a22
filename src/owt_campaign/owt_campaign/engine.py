"""One load case as fast as it can be, for campaigns: the numbers of the pipeline without blocks and report.

Cases on one structure share a :class:`~owt_campaign.shared_model.SharedModel`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.clusters import CLUSTERS, cluster_basis, cluster_label, clusters
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
from owt_model.contracts import EnergyBlock
from owt_model.errors import InputError
from owt_postproc.core import stage as fatigue_stage
from owt_postproc.core.stage import FatigueResult
from owt_structure_node.core import stage as response_stage
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
    "clusters",
    "evaluate_case",
    "model_key",
    "prepare_model",
]

#: Load samples worked on at a time.
BLOCK = 250


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
        The reduction in use, and what is to be said of it.
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
    keeper = SeriesKeeper(keep, model.mesh)
    tower_top = tower_top_load(case, model.mesh)
    clock.lap("tower-top load")
    cut = case.model_copy(update={"stream": case.stream.model_copy(update={"block": BLOCK})})
    wave = WaveStage(cut, model.mesh, hydro=model.hydro)
    wave.history()
    clock.lap("waves and loads")
    basis = case_load_basis(model, case, wave)
    clock.lap("load basis")
    response = case_response(model, case, basis, tower_top)
    clock.lap("reduction")
    response_state = response_stage.initial_state(response)
    fatigue_state = fatigue_stage.initial_state(model.fatigue)
    energies: list[EnergyBlock] = []
    for i in range(wave.n_blocks):
        clock.start()
        load = wave.load_block(i)
        clock.lap("waves and loads")
        wrench = None if tower_top is None else tower_top.block(load)
        response_state, out = response_stage.step(response, response_state, load, wrench)
        clock.lap("response and stress")
        fatigue_state, _ = fatigue_stage.step(model.fatigue, fatigue_state, out.stress)
        clock.lap("rainflow")
        energies.append(out.energy)
        keeper.add(wave, i, load, out, response.description)
    return CaseOutcome(
        case=case,
        fatigue=fatigue_stage.final(model.fatigue, fatigue_state),
        energy=_statistics(response.description.substructure_name, energies),
        stage_seconds=clock.seconds,
        series=keeper.series(),
        reduction=response.description.reduction,
        notes=response.description.notes,
    )


def _statistics(names: tuple[str, ...], blocks: list[EnergyBlock]) -> EnergyStatistics:
    """Statistics of the total, then of the substructures."""
    columns = []
    for kind in ("potential", "kinetic"):
        total = np.concatenate([getattr(block, kind) for block in blocks])
        parts = np.concatenate([getattr(block, f"{kind}_substructure") for block in blocks])
        columns.append(np.column_stack([total, parts]))
    potential, kinetic = columns
    return EnergyStatistics(
        ("total", *names),
        potential.mean(axis=0), potential.std(axis=0), kinetic.mean(axis=0), kinetic.std(axis=0),
    )  # fmt: skip
