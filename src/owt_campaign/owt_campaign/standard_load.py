"""The sea whose loads give the load vectors of the reductions in thesis table B.1 and figure B.4."""

from __future__ import annotations

from typing import Any

from owt_model.config import parse_case
from owt_model.contracts import LoadBasis
from owt_model.mesh import build_mesh
from owt_model.structure import Structure
from owt_wave_node.core.stage import build_wave_stage

__all__ = ["SHAPES_DEG", "STANDARD_SEA", "standard_load_basis"]

#: Second-order loads of the highest sea state of chapter 6; the thesis names no sea for table B.1.
STANDARD_SEA: dict[str, dict[str, Any]] = {
    "sea_state": {"hs_m": 8.25, "tp_s": 11.5, "direction_deg": 210.0, "seed": 1},
    "wave": {"order": 2},
}
#: Figure B.4 is of that sea state as chapter 6.3 has it: table 4.5 holds it from 270 degrees only.
SHAPES_DEG = 270.0


def standard_load_basis(
    structure: Structure, vectors: int, *, direction_deg: float | None = None
) -> LoadBasis:
    """Decompose the loads of :data:`STANDARD_SEA` on a structure into its `vectors` most energetic shapes.

    Parameters
    ----------
    structure : Structure
    vectors : int
    direction_deg : float, optional
        Direction that the waves travel to, where it is not that of the sea.
    """
    sea = STANDARD_SEA["sea_state"]
    if direction_deg is not None:
        sea = {**sea, "direction_deg": direction_deg}
    case = parse_case({**STANDARD_SEA, "sea_state": sea})
    return build_wave_stage(case, build_mesh(structure)).load_basis(vectors)
