"""Proper orthogonal decomposition of a load history (thesis appendix E).

The producer of the loads and the reduction both speak of this basis, so it lives between them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import blas, eigh
from scipy.sparse.linalg import eigsh, svds

from owt_model.block_lanczos import leading_shapes
from owt_model.contracts import LoadBasis
from owt_model.errors import InputError

__all__ = [
    "BANDS",
    "CaseScatter",
    "Scatter",
    "case_scatter",
    "clustered_basis",
    "joined_basis",
    "load_basis",
]

#: Largest residual |X v - sigma u| / sigma_1 of a Lanczos vector that is accepted.
TOLERANCE = 1e-11
#: Up to this size the dense decomposition is the faster one.
DENSE = 200
#: Bands of the spectra of amplitudes, from 0 to half the sampling frequency.
BANDS = 256
#: Share of the variance of the loads below their highest frequency, and random sums of loads that tell it.
BELOW_HIGHEST, SUMS = 0.999, 16
#: Snapshots whose mean is removed at a time, and rows.
CHUNK, ROWS = 512, 32


def load_basis(
    nodal: Float[np.ndarray, "snapshot loaded 6"],
    node: Int[np.ndarray, " loaded"],
    n_vectors: int,
    *,
    model_hash: str,
) -> LoadBasis:
    """Return the `n_vectors` most energetic spatial vectors of a load history [eq. E.3-E.7].

    The mean is removed first (E.3). A Lanczos method finds just the leading singular triplets. Histories with
    time last in memory are not copied.

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

    Returns
    -------
    LoadBasis
        With fewer vectors where the history has fewer independent shapes.
    """
    n_snapshots = nodal.shape[0]
    mean = nodal.mean(axis=0)
    rows, row_mean = nodal.reshape(n_snapshots, -1).T, mean.reshape(-1)
    variance = _variance(rows, row_mean)
    if n_vectors == 0 or variance == 0.0:
        bare = LoadBasis(
            model_hash, node, np.zeros((0, *mean.shape)), np.zeros(0), variance, mean, n_snapshots
        )
        return replace(bare, highest_frequency=_highest_frequency(rows, row_mean, variance))
    found = leading_shapes(rows, row_mean, n_vectors)
    sigma, vectors = _leading((rows - row_mean[:, None]).T, n_vectors) if found is None else found
    floor = np.sqrt(variance) * np.finfo(float).eps * max(rows.shape)
    sigma, vectors = _kept(sigma, vectors, floor)
    return LoadBasis(
        model_hash=model_hash,
        node=node,
        vectors=vectors.reshape(len(sigma), *mean.shape),
        singular_values=sigma,
        total_variance=variance,
        mean=mean,
        snapshots=n_snapshots,
        spectrum=_spectrum(_amplitudes(rows, row_mean, vectors)),
        highest_frequency=_highest_frequency(rows, row_mean, variance),
    )


def clustered_basis(
    histories: Iterable[Float[np.ndarray, "_ _ 6"]],
    node: Int[np.ndarray, " loaded"],
    n_vectors: int,
    *,
    model_hash: str,
) -> LoadBasis:
    """Vectors that serve several load cases: the POD of their snapshot matrices side by side.

    Of each case the mean is removed, and what is left is divided by its Frobenius norm, so that every case
    counts the same (thesis 6.3: clusters *dir*, *hs* and *tot*; *spec* is a cluster of one case). Without it
    the highest sea state decides alone. One case is held at a time.

    Parameters
    ----------
    histories : iterable of float arrays [snapshot, loaded, 6]
        Loads of the cases, all on the nodes `node`; an iterator may compute them one by one.
    node : int array [loaded]
        The loaded nodes.
    n_vectors : int
        Number of vectors to keep.
    model_hash : str
        Content hash of the structure that the loads belong to.

    Returns
    -------
    LoadBasis
        Its singular values and variance are those of the normalised snapshots (a variance of 1 per case that
        changes in time), its mean is that of the cases' means.

    Raises
    ------
    InputError
        If there is no case, or one has other nodes.
    """

    def parts() -> Iterator[CaseScatter]:
        for nodal in histories:
            if nodal.shape[1] != len(node):
                raise InputError(
                    "load history",
                    nodal.shape[1],
                    f"must have {len(node)} nodes, as the others",
                    "Use one mesh.",
                )
            yield case_scatter(nodal)

    return joined_basis(parts(), node, n_vectors, model_hash=model_hash)


@dataclass(frozen=True)
class CaseScatter:
    """What a case adds to a basis that it shares: 8 bytes per pair of load components.

    Attributes
    ----------
    mean : float array [loaded, 6]
        Mean load.
    matrix : float array [loaded*6, loaded*6]
        Upper triangle of the scatter of what is left, divided by its trace: the square of the Frobenius norm.
    snapshots : int
        Snapshots that it was made from.
    """

    mean: Float[np.ndarray, "loaded 6"]
    matrix: Float[np.ndarray, "dof dof"]
    snapshots: int


def case_scatter(nodal: Float[np.ndarray, "snapshot loaded 6"]) -> CaseScatter:
    """Normalised scatter of the loads of one case."""
    mean = nodal.mean(axis=0)
    rows, row_mean = nodal.reshape(len(nodal), -1).T, mean.reshape(-1)
    matrix = np.zeros((len(rows), len(rows)), order="F")
    for i in range(0, len(nodal), CHUNK):
        part = np.asfortranarray(rows[:, i : i + CHUNK] - row_mean[:, None])
        matrix = blas.dsyrk(1.0, part, beta=1.0, c=matrix, overwrite_c=1)
    variance = float(np.trace(matrix))
    return CaseScatter(mean, matrix / variance if variance > 0.0 else matrix, len(nodal))


def joined_basis(
    parts: Iterable[CaseScatter], node: Int[np.ndarray, " loaded"], n_vectors: int, *, model_hash: str
) -> LoadBasis:
    """Basis of several cases from their parts, which are added in the order in which they come.

    Parameters and result as in :func:`clustered_basis`.

    Raises
    ------
    InputError
        If there is no part.
    """
    total, mean, snapshots, count = np.zeros((0, 0)), np.zeros((0, 6)), 0, 0
    for part in parts:
        total = total + part.matrix if count else part.matrix
        mean = mean + part.mean if count else part.mean
        snapshots, count = snapshots + part.snapshots, count + 1
    if not count:
        raise InputError("load histories", 0, "must be one or more", "Give the loads of a case.")
    mean = mean / count
    sigma, vectors = _of_scatter(total, mean.shape, n_vectors)
    return LoadBasis(model_hash, node, vectors, sigma, float(np.trace(total)), mean, snapshots)


def _of_scatter(
    matrix: Float[np.ndarray, "dof dof"], shape: tuple[int, ...], n_vectors: int
) -> tuple[Float[np.ndarray, " value"], Float[np.ndarray, "value loaded 6"]]:
    """Singular values and vectors from the upper triangle of a scatter matrix."""
    if not n_vectors:
        return np.zeros(0), np.zeros((0, *shape))
    value, vectors = _largest(matrix, n_vectors)
    sigma = np.sqrt(np.maximum(value, 0.0))
    floor = np.sqrt(float(np.trace(matrix)) * np.finfo(float).eps * len(matrix))
    sigma, vectors = _kept(sigma, vectors, floor)
    return sigma, vectors.reshape(len(sigma), *shape)


class Scatter:
    """Mean and scatter matrix of a load history that is never held: snapshots are added window by window.

    The basis agrees with that of :func:`load_basis` to about 1e-16 (sigma_1 / sigma_i)^2: the squares of the
    singular values are what is known, so shapes with less than 1e-7 of the largest count as none. Work
    does not depend on how the history is cut; memory is that of the matrix, 8 bytes per pair of load
    components.
    """

    def __init__(self) -> None:
        self.count = 0
        self._mean: Float[np.ndarray, " dof"] = np.zeros(0)
        self._matrix: Float[np.ndarray, "dof dof"] = np.zeros((0, 0))
        self._shape = (0, 6)

    def add(self, nodal: Float[np.ndarray, "snapshot loaded 6"]) -> None:
        """Add snapshots and update the mean [Chan, Golub and LeVeque, Am. Stat. 37, 1983, eq. 2.1]."""
        if not self.count:
            self._shape = (nodal.shape[1], 6)
            self._mean = np.zeros(6 * nodal.shape[1])
            self._matrix = np.zeros((self._mean.size, self._mean.size), order="F")
        for i in range(0, len(nodal), CHUNK):
            part = np.array(nodal[i : i + CHUNK], order="C").reshape(-1, self._mean.size)
            mean = part.mean(axis=0)
            part -= mean
            shift, total = mean - self._mean, self.count + len(part)
            # One more snapshot carries what the shift of the mean adds.
            extra = shift * np.sqrt(self.count * len(part) / total)
            self._matrix = blas.dsyrk(
                1.0, np.vstack([part, extra]).T, beta=1.0, c=self._matrix, overwrite_c=1
            )
            self._mean += shift * (len(part) / total)
            self.count = total

    def basis(self, node: Int[np.ndarray, " loaded"], n_vectors: int, *, model_hash: str) -> LoadBasis:
        """Most energetic spatial vectors of all snapshots added: `n_vectors`, or as many as there are."""
        mean = self._mean.reshape(self._shape)
        sigma, vectors = _of_scatter(self._matrix, self._shape, n_vectors)
        return LoadBasis(model_hash, node, vectors, sigma, float(np.trace(self._matrix)), mean, self.count)


def _kept(
    sigma: Float[np.ndarray, " value"], vectors: Float[np.ndarray, "value dof"], floor: float
) -> tuple[Float[np.ndarray, " kept"], Float[np.ndarray, "kept dof"]]:
    """Leave out what does not rise above round-off, and give each vector a sign of its own."""
    rank = int(np.count_nonzero(sigma > floor))
    sigma, vectors = sigma[:rank], vectors[:rank]
    # An SVD leaves the sign open: the largest entry of each vector is made positive.
    largest = vectors[np.arange(rank), np.abs(vectors).argmax(axis=1)]
    return sigma, np.asarray(vectors * np.sign(largest)[:, None])


def _variance(rows: Float[np.ndarray, "dof snapshot"], mean: Float[np.ndarray, " dof"]) -> float:
    """Sum of the squares of all rows, each without its mean."""
    total = 0.0
    for i in range(0, len(rows), ROWS):
        part = rows[i : i + ROWS] - mean[i : i + ROWS, None]
        total += float(np.einsum("ds,ds->", part, part))
    return total


def _amplitudes(
    rows: Float[np.ndarray, "dof snapshot"],
    mean: Float[np.ndarray, " dof"],
    vectors: Float[np.ndarray, "shape dof"],
) -> Float[np.ndarray, "shape snapshot"]:
    """Amplitudes of shapes in the rows without their mean."""
    return np.asarray(vectors @ rows - (vectors @ mean)[:, None])


def _spectrum(amplitude: Float[np.ndarray, "shape snapshot"]) -> Float[np.ndarray, "shape band"]:
    """Variance of each amplitude in :data:`BANDS` equal bands up to half the sampling frequency."""
    n = amplitude.shape[1]
    power = np.abs(np.fft.rfft(amplitude)) ** 2 / n**2
    power[:, 1 : (n + 1) // 2] *= 2.0  # all but frequency 0 and the folding frequency stand for two lines
    band = np.minimum(2 * BANDS * np.arange(power.shape[1]) // n, BANDS - 1)
    return np.array([np.bincount(band, weights=row, minlength=BANDS) for row in power])


def _highest_frequency(
    rows: Float[np.ndarray, "dof snapshot"], mean: Float[np.ndarray, " dof"], variance: float
) -> float:
    """Frequency in cycles per sample below which nearly all variance lies; 0 of loads that do not change.

    Sums of all loads with random signs, each load on its own scale in newtons, stand for their spectra.
    """
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(rows), SUMS)).T
    share = np.cumsum(_spectrum(_amplitudes(rows, mean, signs)).sum(axis=0))
    if not (variance > 0.0 and share[-1] > 0.0):
        return 0.0
    return (int(np.searchsorted(share, BELOW_HIGHEST * share[-1])) + 1) / (2.0 * BANDS)


def _largest(
    upper: Float[np.ndarray, "dof dof"], count: int
) -> tuple[Float[np.ndarray, " value"], Float[np.ndarray, "value dof"]]:
    """Largest eigenvalues and their vectors of a symmetric matrix given by its upper triangle."""
    matrix = np.triu(upper) + np.triu(upper, 1).T
    size = len(matrix)
    if size > max(DENSE, 4 * count) and matrix.any():
        start = np.random.default_rng(0).standard_normal(size)  # fixed: same bits every run
        value, vectors = eigsh(matrix, k=count, v0=start, tol=0)
        value, vectors = value[::-1], vectors[:, ::-1]
        if np.linalg.norm(matrix @ vectors - vectors * value, axis=0).max() <= TOLERANCE * value[0]:
            return value, np.ascontiguousarray(vectors.T)
    count = min(count, size)
    value, vectors = eigh(matrix, subset_by_index=(size - count, size - 1))
    return value[::-1].copy(), np.ascontiguousarray(vectors[:, ::-1].T)


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
