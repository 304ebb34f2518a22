"""Load bases that several cases share (thesis chapter 6.3): one per direction, per sea state, or for all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_campaign.shared_model import SharedModel, check_key, prepare_model
from owt_model.config import CaseConfig
from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.pod import CaseScatter, case_scatter, joined_basis
from owt_structure_node.core.response_model import n_mta
from owt_wave_node.core.stage import WaveStage
from owt_wave_node.sea_source import resolve_case

__all__ = [
    "CLUSTERS",
    "ClusterPart",
    "cluster_basis",
    "cluster_label",
    "cluster_part",
    "clusters",
    "join_cluster",
]

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


@dataclass(frozen=True)
class ClusterPart:
    """What one case adds to the load vectors of its cluster; parts can be made apart, on any worker."""

    scatter: CaseScatter
    node: Int[np.ndarray, " loaded"]
    vectors: int
    model_hash: str


def cluster_part(case: CaseConfig, model: SharedModel | None = None) -> ClusterPart:
    """Loads of a case as the load vectors of its cluster need them.

    Parameters
    ----------
    case : CaseConfig
        The case.
    model : SharedModel, optional
        From :func:`owt_campaign.shared_model.prepare_model`; prepared here where left out.

    Raises
    ------
    InputError
        If the case is refused or does not share the model.
    """
    case = resolve_case(case)
    shared = prepare_model(case) if model is None else model
    check_key(shared, case)
    stage = WaveStage(case, shared.mesh, hydro=shared.hydro)
    return ClusterPart(
        scatter=case_scatter(_nodal(stage)),
        node=stage.windows.hydro.node,
        vectors=n_mta(case.structure.reduction),
        model_hash=stage.model_hash,
    )


def join_cluster(parts: Iterable[ClusterPart]) -> LoadBasis:
    """Load vectors of a cluster from the parts of its cases; they are added in their order, one at a time.

    Raises
    ------
    InputError
        If there is none, or they belong to several structures.
    """
    rest = iter(parts)
    first = next(rest, None)
    if first is None:
        raise InputError("cases", 0, "must be one or more", "Give the cases of a cluster.")

    def scatters() -> Iterator[CaseScatter]:
        yield first.scatter
        for part in rest:
            if part.model_hash != first.model_hash or not np.array_equal(part.node, first.node):
                raise InputError(
                    "cases",
                    part.model_hash[:12],
                    "are on several structures",
                    "Cluster cases on one structure.",
                )
            yield part.scatter

    return joined_basis(scatters(), first.node, first.vectors, model_hash=first.model_hash)


def cluster_basis(cases: Iterable[CaseConfig], model: SharedModel | None = None) -> LoadBasis:
    """Load vectors that serve several cases: the POD of their normalised snapshots side by side.

    Of each case the mean load is removed and the rest divided by its Frobenius norm; without it the highest
    sea state decides alone. The loads of one case are held at a time, and two matrices of 8 bytes per pair of
    load components. :func:`cluster_part` and :func:`join_cluster` do the same in parts, to the bit.

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
    given = list(cases)
    shared = prepare_model(given[0]) if model is None and given else model
    return join_cluster(cluster_part(case, shared) for case in given)


def _nodal(stage: WaveStage) -> Float[np.ndarray, "snapshot loaded 6"]:
    """Nodal loads of a record."""
    parts = [window.nodal for window in stage.windows]
    nodal = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=2)
    return nodal.transpose(2, 0, 1)
