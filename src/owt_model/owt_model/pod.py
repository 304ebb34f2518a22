"""Proper orthogonal decomposition of a load history (thesis appendix E).

The producer of the loads and the reduction both speak of this basis, so it lives between them.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from owt_model.contracts import LoadBasis
from owt_model.errors import InputError

__all__ = ["load_basis"]


def load_basis(
    nodal: Float[np.ndarray, "snapshot loaded 6"],
    node: Int[np.ndarray, " loaded"],
    n_vectors: int,
    *,
    model_hash: str,
) -> LoadBasis:
    """Return the `n_vectors` most energetic spatial vectors of a load history [eq. E.3-E.7].

    The mean is removed first (E.3). The method of snapshots is not used: a thin SVD of the
    time-by-space matrix keeps the small singular values that the covariance matrix squares away.

    Parameters
    ----------
    nodal : float array [snapshot, loaded, 6]
        Nodal forces in N and moments in N m.
    node : int array [loaded]
        The loaded nodes.
    n_vectors : int
        Number of vectors to keep.
    model_hash : str
        Content hash of the structure that the loads belong to.

    Raises
    ------
    InputError
        If the history has fewer independent shapes than `n_vectors`.
    """
    n_snapshots = nodal.shape[0]
    mean = nodal.mean(axis=0)
    if n_vectors == 0:
        empty = np.zeros((0, *mean.shape))
        return LoadBasis(model_hash, node, empty, np.zeros(0), mean, n_snapshots)
    snapshots = (nodal - mean).reshape(n_snapshots, -1)
    # QR first: the SVD then works on a square triangle, whatever the number of snapshots.
    if snapshots.shape[0] > snapshots.shape[1]:
        triangle = np.linalg.qr(snapshots, mode="r")
        _, sigma, shapes = np.linalg.svd(triangle, full_matrices=False)
    else:
        _, sigma, shapes = np.linalg.svd(snapshots, full_matrices=False)
    rank = int(np.count_nonzero(sigma > sigma[0] * np.finfo(float).eps * max(snapshots.shape)))
    if n_vectors > rank:
        raise InputError(
            "structure.reduction",
            f"{n_vectors} MTA vectors",
            f"needs a load history with as many independent shapes, this one has {rank}",
            "Use fewer MTA vectors or a longer record.",
        )
    vectors = shapes[:n_vectors]
    # An SVD leaves the sign open: the largest entry of each vector is made positive.
    largest = vectors[np.arange(n_vectors), np.abs(vectors).argmax(axis=1)]
    vectors = vectors * np.sign(largest)[:, None]
    return LoadBasis(model_hash, node, vectors.reshape(n_vectors, -1, 6), sigma, mean, n_snapshots)
