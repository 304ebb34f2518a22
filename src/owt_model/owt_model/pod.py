"""Proper orthogonal decomposition of a load history (thesis appendix E).

The producer of the loads and the reduction both speak of this basis, so it lives between them.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse.linalg import svds

from owt_model.contracts import LoadBasis
from owt_model.errors import InputError

__all__ = ["load_basis"]

#: Largest residual |X v - sigma u| / sigma_1 of a Lanczos vector that is accepted.
TOLERANCE = 1e-11
#: Up to this size the dense decomposition is the faster one.
DENSE = 200


def load_basis(
    nodal: Float[np.ndarray, "snapshot loaded 6"],
    node: Int[np.ndarray, " loaded"],
    n_vectors: int,
    *,
    model_hash: str,
) -> LoadBasis:
    """Return the `n_vectors` most energetic spatial vectors of a load history [eq. E.3-E.7].

    The mean is removed first (E.3). A restarted Lanczos method finds just the leading singular triplets.

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
    snapshots = (nodal - mean).reshape(n_snapshots, -1)
    variance = float(np.vdot(snapshots, snapshots))
    if n_vectors == 0:
        return LoadBasis(
            model_hash, node, np.zeros((0, *mean.shape)), np.zeros(0), variance, mean, n_snapshots
        )
    sigma, vectors = _leading(snapshots, n_vectors)
    floor = np.sqrt(variance) * np.finfo(float).eps * max(snapshots.shape)
    rank = int(np.count_nonzero(sigma > floor))
    if rank < n_vectors:
        raise InputError(
            "structure.reduction",
            f"{n_vectors} MTA vectors",
            f"needs a load history with as many independent shapes, this one has {rank}",
            "Use fewer MTA vectors or a longer record.",
        )
    # An SVD leaves the sign open: the largest entry of each vector is made positive.
    largest = vectors[np.arange(n_vectors), np.abs(vectors).argmax(axis=1)]
    vectors = vectors * np.sign(largest)[:, None]
    return LoadBasis(model_hash, node, vectors.reshape(n_vectors, -1, 6), sigma, variance, mean, n_snapshots)


def _leading(
    snapshots: Float[np.ndarray, "snapshot dof"], n_vectors: int
) -> tuple[Float[np.ndarray, " value"], Float[np.ndarray, "value dof"]]:
    """Leading singular values and right singular vectors, largest first.

    The Lanczos result is taken only if its residuals are small; else the dense decomposition decides.
    """
    if min(snapshots.shape) > max(DENSE, 4 * n_vectors) and snapshots.any():
        start = np.random.default_rng(0).standard_normal(min(snapshots.shape))  # fixed: same bits every run
        left, sigma, vectors = svds(snapshots, k=n_vectors, solver="arpack", v0=start, tol=0)
        order = np.argsort(sigma)[::-1]
        left, sigma, vectors = left[:, order], sigma[order], vectors[order]
        residual = np.linalg.norm(snapshots @ vectors.T - left * sigma, axis=0).max() / sigma[0]
        if residual <= TOLERANCE:
            return sigma, vectors
    _, sigma, vectors = np.linalg.svd(snapshots, full_matrices=False)
    return sigma[:n_vectors], vectors[:n_vectors]
