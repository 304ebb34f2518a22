"""Interpolation at Chebyshev nodes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from jaxtyping import Float

__all__ = ["chebyshev_basis"]


@lru_cache(maxsize=64)
def chebyshev_basis(count: int) -> tuple[Float[np.ndarray, " node"], Float[np.ndarray, "order node"]]:
    """Return `count` nodes in (-1, 1), and the matrix from values there to coefficients of the series.

    Nodes are the zeros of the Chebyshev polynomial of degree `count`, from the highest down. Both arrays are
    kept and must not be changed.
    """
    angle = np.pi * (np.arange(count) + 0.5) / count
    matrix = np.cos(np.outer(np.arange(count), angle)) * (2.0 / count)
    matrix[0] *= 0.5
    node = np.cos(angle)
    node.flags.writeable = matrix.flags.writeable = False
    return node, matrix
