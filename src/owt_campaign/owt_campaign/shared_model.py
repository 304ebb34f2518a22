"""What load cases on one structure share: mesh, matrices, stations in the water, counting, reduction."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace

import numpy as np

from owt_model.config import CaseConfig
from owt_model.contracts import LoadBasis
from owt_model.errors import InputError
from owt_model.frame import frame_of_mesh
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import Structure, case_structure
from owt_postproc.core import stage as fatigue_stage
from owt_postproc.core.hot_spots import build_hot_spots
from owt_structure_node.core.response import StructureParts, structure_parts
from owt_structure_node.core.response_model import ResponseModel, build_response_model, n_mta
from owt_structure_node.core.tower_top import TowerTopLoad
from owt_wave_node.core.hydro_mesh import HydroMesh, case_hydro_mesh
from owt_wave_node.core.stage import WaveStage

__all__ = ["SharedModel", "case_load_basis", "case_response", "model_key", "prepare_model"]

#: Parts of a case that the shared model depends on; the sea, its order and the wind are the case's own.
SHARED = ("structure", "water_depth_m", "morison", "fatigue")


@dataclass(frozen=True)
class SharedModel:
    """What cases of one :func:`model_key` share.

    Attributes
    ----------
    key : str
        From :func:`model_key`.
    mesh : Mesh
    parts : StructureParts
        Matrices, static reduction and lowest modes of the structure.
    fatigue : FatigueModel
        Hot spots and S-N curves.
    hydro : HydroMesh, optional
        Stations on the members; None where they depend on the waves (``morison.points`` "gauss").
    basis : LoadBasis, optional
        Load vectors that the cases share; None where each has its own.
    response : ResponseModel, optional
        The reduced and decoupled structure; None where it depends on the loads of the case.
    """

    key: str
    mesh: Mesh
    parts: StructureParts
    fatigue: fatigue_stage.FatigueModel
    hydro: HydroMesh | None
    basis: LoadBasis | None
    response: ResponseModel | None

    def with_basis(self, case: CaseConfig, basis: LoadBasis | None) -> SharedModel:
        """Return the model of the cases that share the load vectors `basis`; all else is this one's.

        Parameters
        ----------
        case : CaseConfig
            Any of the cases.
        basis : LoadBasis, optional
            None where each case has its own.
        """
        check_key(self, case)
        return replace(self, basis=basis, response=_shared_response(case, self.mesh, self.parts, basis))


def model_key(case: CaseConfig) -> str:
    """Hash of what the shared model depends on: cases of the same key can share one.

    A structure in a file counts by its path: its content must not change between the cases.
    """
    data = case.model_dump(mode="json", include=set(SHARED)) | {"dt_s": case.time.dt_s}
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()


def prepare_model(
    case: CaseConfig, *, basis: LoadBasis | None = None, structure: Structure | None = None
) -> SharedModel:
    """Build what the cases on the structure of `case` share.

    Parameters
    ----------
    case : CaseConfig
        Any of the cases.
    basis : LoadBasis, optional
        Load vectors for all of them, as :func:`owt_campaign.clusters.cluster_basis` gives; each case
        decomposes its own loads where left out.
    structure : Structure, optional
        In the place of the one that the case names.

    Raises
    ------
    InputError
        If the structure or its reduction is refused.
    ComputationError
        If a numerical step fails.
    """
    mesh = build_mesh(case_structure(case.structure, structure))
    parts = structure_parts(mesh, case.structure.reduction)
    return SharedModel(
        key=model_key(case),
        mesh=mesh,
        parts=parts,
        fatigue=fatigue_stage.build_fatigue_model(case, build_hot_spots(frame_of_mesh(mesh), case.fatigue)),
        hydro=None if case.morison.points == "gauss" else case_hydro_mesh(case, mesh, lowest=-np.inf),
        basis=basis,
        response=_shared_response(case, mesh, parts, basis),
    )


def check_key(model: SharedModel, case: CaseConfig) -> None:
    """Refuse a case that cannot share a model.

    Raises
    ------
    InputError
        Naming the first part of the case that differs.
    """
    if model_key(case) != model.key:
        raise InputError(
            "model",
            model.mesh.structure.name,
            f"was prepared for a case that differs in one of {', '.join(SHARED)}, time.dt_s",
            "Prepare a model for this case.",
        )


def case_load_basis(model: SharedModel, case: CaseConfig, wave: WaveStage) -> LoadBasis | None:
    """Load vectors of a case: those shared, with its own damping by drag, or its own; None if none count."""
    vectors = n_mta(case.structure.reduction)
    if model.basis is None:
        return wave.load_basis(vectors) if vectors or case.morison.hydrodynamic_damping else None
    if case.morison.hydrodynamic_damping:
        return replace(model.basis, damping=wave.load_basis(0).damping)
    return model.basis


def case_response(
    model: SharedModel, case: CaseConfig, basis: LoadBasis | None, tower_top: TowerTopLoad | None
) -> ResponseModel:
    """The shared response model where there is one and the rotor adds no damping; else one of the case."""
    damped = tower_top is not None and len(tower_top.dashpots) > 0
    if model.response is not None and not damped:
        return model.response
    return build_response_model(case, model.mesh, basis, tower_top, parts=model.parts)


def _shared_response(
    case: CaseConfig, mesh: Mesh, parts: StructureParts, basis: LoadBasis | None
) -> ResponseModel | None:
    """Response model of all cases, where their loads do not change it."""
    own_vectors = basis is None and n_mta(case.structure.reduction) > 0
    if own_vectors or case.morison.hydrodynamic_damping:
        return None
    return build_response_model(case, mesh, basis, parts=parts)
