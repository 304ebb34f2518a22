"""Leading left singular vectors of a tall record of loads by a block Lanczos method.

Every pass over the record serves a block of vectors at once and a chunk of samples while it is in cache; the
mean is taken off the products, so that no second copy of the record is made.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

__all__ = ["leading_shapes"]

#: Vectors of a block beyond those asked for, and blocks after which the method gives up.
MORE, MAX_BLOCKS = 6, 12
#: Samples per vector whose random sums are the first block.
START = 8
#: Residual |C v - sigma^2 v| over the largest sigma^2 below which all vectors count as found.
TOLERANCE = 1e-12
#: Square of the smallest singular value over the largest below which squares know too little of it.
SMALLEST = 1e-7
#: Bytes of the record that are worked on at a time.
CHUNK_BYTES = 2 * 2**20

Block = Float[np.ndarray, "dof vector"]


def leading_shapes(
    rows: Float[np.ndarray, "dof sample"], mean: Float[np.ndarray, " dof"], count: int
) -> tuple[Float[np.ndarray, " value"], Float[np.ndarray, "value dof"]] | None:
    """Largest singular values and left singular vectors of `rows` - `mean`, largest first.

    Works with C = (rows - mean)(rows - mean)' and orthogonalises every block against all before it, so that
    the result is good to about 1e-16 (sigma_1 / sigma_i)^2 over the distance to the next value.

    Returns
    -------
    sigma, vectors
        None where the iteration does not converge, or the record has fewer distinct shapes than asked for:
        another method has to decide then.
    """
    dof, samples = rows.shape
    width = count + MORE
    if count < 1 or (MAX_BLOCKS // 2) * width > min(dof, samples):
        return None
    some = rows[:, :: max(1, samples // (START * width))]
    weights = np.random.default_rng(0).standard_normal((some.shape[1], width))  # fixed: same bits every run
    block = np.linalg.qr(some @ weights - mean[:, None] * weights.sum(axis=0))[0]
    basis = block
    small = np.zeros((0, 0))
    for _ in range(MAX_BLOCKS):
        product = _product(rows, mean, block)
        inner = basis.T @ product
        product -= basis @ inner
        product -= basis @ (basis.T @ product)  # once more: orthogonal to round-off
        block, rest = np.linalg.qr(product)
        small = _bordered(small, inner)
        value, vector = np.linalg.eigh(small)
        value, vector = value[::-1][:count], vector[:, ::-1][:, :count]
        error = np.linalg.norm(rest @ vector[-width:], axis=0).max()
        if not value[0] > 0.0 or not np.isfinite(error):
            return None
        if error <= TOLERANCE * value[0]:
            if not value[-1] > SMALLEST * value[0]:
                return None
            return np.sqrt(value), np.ascontiguousarray((basis @ vector).T)
        if basis.shape[1] + width > dof:
            return None
        basis = np.hstack([basis, block])
    return None


def _product(rows: Float[np.ndarray, "dof sample"], mean: Float[np.ndarray, " dof"], block: Block) -> Block:
    """C times a block. Amplitudes without their mean do not see the mean of the rows."""
    total, offset = np.zeros(block.shape), mean @ block
    step = max(1, CHUNK_BYTES // (8 * len(rows)))
    for i in range(0, rows.shape[1], step):
        part = rows[:, i : i + step]
        total += part @ (part.T @ block - offset)
    return total


def _bordered(
    small: Float[np.ndarray, "known known"], inner: Float[np.ndarray, "all vector"]
) -> Float[np.ndarray, "all all"]:
    """The projected matrix with the columns of one more block."""
    size, width = inner.shape
    out = np.zeros((size, size))
    out[: size - width, : size - width] = small
    out[:, size - width :] = inner
    out[size - width :] = inner.T
    out[size - width :, size - width :] = 0.5 * (inner[-width:] + inner[-width:].T)
    return out
