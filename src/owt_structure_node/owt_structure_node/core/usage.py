"""How much stress to expect at each member end, before a record is run: which ends a bag should keep.

The load basis says how the loads vary in space and by how much: uncorrelated patterns and their variances.
The static stress of each pattern gives the variance of the normal stress round the section. What the
structure's own motion adds is left out, and so are the fixed-end forces of the loads on the end's element:
it ranks the ends, no more.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBasis
from owt_structure_node.core.recovery import EndSections, stresses
from owt_structure_node.core.reduction import load_vectors
from owt_structure_node.core.response import ModalModel

__all__ = ["expected_stress"]

#: Points round the section: the largest of them is within 8 % of the extreme.
ANGLE = 2.0 * np.pi * np.arange(8) / 8


def expected_stress(
    model: ModalModel,
    end_force: Float[np.ndarray, "function end 6"],
    ends: EndSections,
    basis: LoadBasis | None,
) -> Float[np.ndarray, " end"]:
    """Standard deviation in Pa of the normal stress at the member ends as the loads vary, statically.

    Parameters
    ----------
    model : ModalModel
        Modes of the structure.
    end_force : float array [function, end, 6]
        From :func:`~owt_structure_node.core.recovery.end_force_map`.
    ends : EndSections
        Of the same ends.
    basis : LoadBasis, optional
        Without load vectors, a unit force along x and along y on every joint stands in for them.
    """
    pattern = _patterns(model, basis)
    q = (model.shapes.T @ pattern) / model.omega_squared[:, None]
    amplitude = q if model.amplitude is None else model.amplitude.T @ q
    force = np.einsum("fp,fec->pce", amplitude, end_force)
    # One row per pattern: no substeps, nothing between them.
    stress = stresses(np.ascontiguousarray(force), ends)
    at = (
        stress.axial[:, None]
        + np.sin(ANGLE)[:, None] * stress.bending_y[:, None]
        + np.cos(ANGLE)[:, None] * stress.bending_z[:, None]
    )
    return np.asarray(np.sqrt((at**2).sum(axis=0)).max(axis=0))


def _patterns(model: ModalModel, basis: LoadBasis | None) -> Float[np.ndarray, "dof pattern"]:
    """Loads over the free degrees of freedom, each as large as its standard deviation."""
    assembly = model.assembly
    if basis is not None and len(basis.vectors):
        return np.asarray(load_vectors(assembly, basis) * np.sqrt(basis.pov))
    mesh = assembly.mesh
    uniform = np.zeros((mesh.n_nodes, 6, 2))
    jacket = np.setdiff1d(np.arange(mesh.n_nodes), mesh.tower_node)
    uniform[jacket, 0, 0] = uniform[jacket, 1, 1] = 1.0
    return np.asarray(assembly.expansion.T @ uniform.reshape(6 * mesh.n_nodes, 2))
