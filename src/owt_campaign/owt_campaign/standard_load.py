"""The sea whose loads give the load vectors of the reductions in thesis table B.1."""

from __future__ import annotations

from owt_model.config import parse_case
from owt_model.contracts import LoadBasis
from owt_model.mesh import build_mesh
from owt_model.structure import Structure
from owt_wave_node.core.stage import build_wave_stage

__all__ = ["STANDARD_SEA", "standard_load_basis"]

#: Second-order loads of the highest sea state of chapter 6.
STANDARD_SEA = {
    "sea_state": {"hs_m": 8.25, "tp_s": 11.5, "direction_deg": 210.0, "seed": 1},
    "wave": {"order": 2},
}


def standard_load_basis(structure: Structure, vectors: int) -> LoadBasis:
    """Decompose the loads of :data:`STANDARD_SEA` on a structure into its `vectors` most energetic shapes."""
    return build_wave_stage(parse_case(STANDARD_SEA), build_mesh(structure)).load_basis(vectors)
