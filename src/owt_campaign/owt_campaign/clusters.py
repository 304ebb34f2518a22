"""Load bases that several cases share (thesis chapter 6.3): one per direction, per sea state, or for all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from jaxtyping import Float

from owt_campaign.shared_model import SharedModel, check_key, prepare_model
from owt_model.config import CaseConfig
from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.pod import clustered_basis
from owt_structure_node.core.response_model import n_mta
from owt_wave_node.core.stage import WaveStage
from owt_wave_node.sea_source import resolve_case

__all__ = ["CLUSTERS", "cluster_basis", "cluster_label", "clusters"]

#: Ways to share load vectors: each case has its own, or all cases of a direction, of a height, or all do.
CLUSTERS = ("spec", "dir", "hs", "tot")


def cluster_label(case: CaseConfig, method: str) -> str:
    """Name of the cluster that a case belongs to; empty where each case has its own load vectors.

    Raises
    ------
    InputError
        If there is no such method, or the case has no sea state to tell its cluster.
    """
    if method not in CLUSTERS:
        raise InputError("cluster", method, f"must be one of {', '.join(CLUSTERS)}", "Use spec.")
    if method == "spec":
        return ""
    if method == "tot":
        return "tot"
    if case.sea_state is None:
        raise InputError(
            "cluster", method, "needs cases with sea_state, to tell them apart", "Use spec or tot."
        )
    return f"dir {case.sea_state.direction_deg:g}" if method == "dir" else f"hs {case.sea_state.hs_m:g}"


def clusters(cases: Sequence[CaseConfig], method: str) -> dict[str, list[int]]:
    """Indices of the cases of each cluster, in order; cases that share no model have clusters of their own.

    Raises
    ------
    InputError
        As :func:`cluster_label`.
    """
    found: dict[str, list[int]] = {}
    for i, case in enumerate(cases):
        found.setdefault(cluster_label(case, method), []).append(i)
    return found


def cluster_basis(cases: Iterable[CaseConfig], model: SharedModel | None = None) -> LoadBasis:
    """Load vectors that serve several cases: the POD of their normalised snapshots side by side.

    Of each case the mean load is removed and the rest divided by its Frobenius norm; without it the highest
    sea state decides alone. The loads of one case are held at a time, and a matrix of 8 bytes per pair of
    load components.

    Parameters
    ----------
    cases : iterable of CaseConfig
        Cases that share a model.
    model : SharedModel, optional
        From :func:`owt_campaign.shared_model.prepare_model`; prepared for the first case where left out.

    Raises
    ------
    InputError
        If there is no case, or one of them has another structure or is refused.
    """
    given = [resolve_case(case) for case in cases]
    if not given:
        raise InputError("cases", 0, "must be one or more", "Give the cases of a cluster.")
    shared = prepare_model(given[0]) if model is None else model
    for case in given:
        check_key(shared, case)
    stages = (WaveStage(case, shared.mesh, hydro=shared.hydro) for case in given)
    first = next(stages)

    def histories() -> Iterator[Float[np.ndarray, "snapshot loaded 6"]]:
        yield _nodal(first)
        for stage in stages:
            yield _nodal(stage)

    node = first.windows.hydro.node
    vectors = n_mta(given[0].structure.reduction)
    return clustered_basis(histories(), node, vectors, model_hash=first.model_hash)


def _nodal(stage: WaveStage) -> Float[np.ndarray, "snapshot loaded 6"]:
    """Nodal loads of a record."""
    parts = [window.nodal for window in stage.windows]
    nodal = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=2)
    return nodal.transpose(2, 0, 1)
