"""Displacement of all nodes from the generalised coordinates that the structure node publishes.

The basis is built again from the structure, the name of the reduction in use and the load basis, by the
functions and with the number of modes that the structure node used: modes of equal frequency may turn within
their plane when more or fewer are asked for.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBasis, ReducedDescription
from owt_model.errors import ComputationError
from owt_model.mesh import Mesh
from owt_model.reduction_name import AUTO_MODES, parse_reduction
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.reduction import reduce, solve_interior

__all__ = ["displacement_basis", "node_displacement"]


def displacement_basis(
    mesh: Mesh, description: ReducedDescription, basis: LoadBasis
) -> Float[np.ndarray, "node 3 coordinate"]:
    """Displacement of every node in m per unit of every generalised coordinate.

    The unreduced model (``full``) publishes the motion of transition piece and tower only: below them the
    jacket is then shown as it follows statically.

    Raises
    ------
    ComputationError
        If the basis does not have the coordinates of `description`.
    InputError
        As :func:`owt_structure_node.core.reduction.reduce`.
    """
    assembly, n_published = assemble(mesh), len(description.coordinate_name)
    is_full = description.reduction == "full"
    name = "CB00" if is_full else description.reduction
    chosen = any(note.startswith("auto:") for note in description.notes)
    modes = AUTO_MODES[-1] if chosen else parse_reduction(name).fixed_interface_modes
    interior = solve_interior(assembly, min(modes + 1, assembly.internal))
    reduced = reduce(assembly, name, basis, interior=interior)
    column = {coordinate: i for i, coordinate in enumerate(reduced.coordinate_name)}
    fits = set(description.coordinate_name) <= set(column) and (is_full or len(column) == n_published)
    if not fits:
        raise ComputationError(
            f"the basis {name} has {len(column)} coordinates, the graph publishes {n_published} of "
            f"{description.reduction} that are not the same"
        )
    shown = reduced.shapes[:, [column[coordinate] for coordinate in description.coordinate_name]]
    motion = np.asarray(assembly.expansion @ shown)
    return np.ascontiguousarray(motion.reshape(mesh.n_nodes, 6, -1)[:, :3])


def node_displacement(
    basis: Float[np.ndarray, "node 3 coordinate"], coordinate: Float[np.ndarray, " coordinate"]
) -> Float[np.ndarray, "node 3"]:
    """Displacement of every node in m."""
    return np.asarray(basis @ coordinate)
