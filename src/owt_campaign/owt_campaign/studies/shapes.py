"""Shapes of a structure as lines: each element bent as a beam, seen from above one corner."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Bool, Float

from owt_model.mesh import Mesh

__all__ = ["bent_elements", "seen"]

#: Points per element.
POINTS = 7
#: Where the view comes from: around z from x, and above the horizon.
AROUND, ABOVE = math.radians(62.0), math.radians(18.0)


def bent_elements(
    mesh: Mesh,
    motion: Float[np.ndarray, "node 6"],
    largest: float,
    elements: Bool[np.ndarray, " element"] | None = None,
) -> Float[np.ndarray, "element point 3"]:
    """Axes of the elements under a motion of the nodes, in m.

    Parameters
    ----------
    mesh : Mesh
        The structure.
    motion : float array [node, 6]
        Translations and rotations, of any size.
    largest : float
        Distance in m that the node that moves farthest is shown to move; 0 for the structure at rest.
    elements : bool array [element], optional
        Those wanted; all if left out.
    """
    wanted = np.ones(mesh.n_elements, dtype=bool) if elements is None else elements
    ends = mesh.element_node[wanted]
    at = mesh.node_position[ends]
    axis = at[:, 1] - at[:, 0]
    moves = float(np.linalg.norm(motion[np.unique(ends), :3], axis=1).max())
    scale = largest / moves if moves else 0.0
    place = at + scale * motion[ends, :3]
    tangent = axis[:, None] + scale * np.cross(motion[ends, 3:], axis[:, None])
    s = np.linspace(0.0, 1.0, POINTS)[:, None]
    return np.asarray(
        (2.0 * s**3 - 3.0 * s**2 + 1.0) * place[:, None, 0]
        + (s**3 - 2.0 * s**2 + s) * tangent[:, None, 0]
        + (3.0 * s**2 - 2.0 * s**3) * place[:, None, 1]
        + (s**3 - s**2) * tangent[:, None, 1]
    )


def seen(points: Float[np.ndarray, "*shape 3"]) -> Float[np.ndarray, "*shape 2"]:
    """Points as a distant eye sees them: to the right and up, in m."""
    x, y, z = np.moveaxis(points, -1, 0)
    right = y * math.cos(AROUND) - x * math.sin(AROUND)
    depth = x * math.cos(AROUND) + y * math.sin(AROUND)
    return np.stack([right, z * math.cos(ABOVE) - depth * math.sin(ABOVE)], axis=-1)
