"""Thesis figures B.1 to B.4: modes of the turbine and of its jacket, constraint modes, load vectors."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from owt_campaign.standard_load import SHAPES_DEG, standard_load_basis
from owt_campaign.studies.eigen import MODEL
from owt_campaign.studies.shapes import bent_elements, seen
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.assembly import DOF_NAME, assemble
from owt_structure_node.core.modes import hertz, lowest_modes
from owt_structure_node.core.reduction import reduce

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["EIGEN_FIGURES", "eigen_shapes"]

Shapes = tuple[list[str], Float[np.ndarray, "node 6 shape"]]
#: Farthest motion shown, in m: of the turbine, and of the jacket alone.
TURBINE, JACKET = 14.0, 7.0


@cache
def eigen_shapes() -> tuple[Mesh, dict[str, Shapes]]:
    """Mesh, and for each figure the titles of its panels and the motion of all nodes.

    Raises
    ------
    ComputationError
        If an eigenvalue problem fails.
    """
    structure = load_structure(MODEL)
    assembly = assemble(build_mesh(structure))
    omega2, modes = lowest_modes(assembly.stiffness, assembly.mass, 10)
    loads = standard_load_basis(structure, 10, direction_deg=SHAPES_DEG)
    reduced = reduce(assembly, "CB10M10", loads)

    def motion(shapes: Float[np.ndarray, "dof shape"]) -> Float[np.ndarray, "node 6 shape"]:
        return np.asarray(assembly.expansion @ shapes).reshape(assembly.mesh.n_nodes, 6, -1)

    def columns(kind: str, count: int) -> Float[np.ndarray, "node 6 shape"]:
        found = [i for i, name in enumerate(reduced.coordinate_name) if name.startswith(kind)]
        return motion(reduced.shapes[:, found[:count]])

    return assembly.mesh, {
        "modes": ([f"{i + 1}: {f:.3f} Hz" for i, f in enumerate(hertz(omega2))], motion(modes)),
        "constraint-modes": ([f"interface {name}" for name in DOF_NAME], columns("TP.", 6)),
        "fixed-interface-modes": (
            [f"{i + 1}: {f:.3f} Hz" for i, f in enumerate(hertz(reduced.fixed_interface))],
            columns("CB.", 10),
        ),
        "load-vectors": (
            [f"MTA {i + 1}: {f:.1f} Hz" for i, f in enumerate(hertz(reduced.pseudo[:5]))],
            columns("MTA.", 5),
        ),
    }


def _draw(key: str, columns: int, size: tuple[float, float]) -> Figure:
    from owt_campaign.studies.plotting import BLUE, GRID, canvas, frame

    mesh, found = eigen_shapes()
    titles, motion = found[key]
    whole = key == "modes"
    shown = np.ones(mesh.n_elements, dtype=bool) if whole else ~mesh.is_tower
    figure, panels = canvas(-(-len(titles) // columns), columns, size)
    still = seen(bent_elements(mesh, 0.0 * motion[:, :, 0], 0.0, shown))
    for i, panel in enumerate(panels.flat):
        if i >= len(titles):
            panel.axis("off")
            continue
        frame(panel, still, colour=GRID, width=0.8)
        bent = bent_elements(mesh, motion[:, :, i], TURBINE if whole else JACKET, shown)
        frame(panel, seen(bent), colour=BLUE, width=0.9)
        panel.set_title(titles[i])
    return figure


#: Figures of the page: key -> what draws it.
EIGEN_FIGURES: dict[str, Callable[[], Figure]] = {
    "modes": lambda: _draw("modes", 5, (9.0, 8.6)),
    "constraint-modes": lambda: _draw("constraint-modes", 6, (9.0, 2.6)),
    "fixed-interface-modes": lambda: _draw("fixed-interface-modes", 5, (9.0, 5.6)),
    "load-vectors": lambda: _draw("load-vectors", 5, (9.0, 3.0)),
}
