"""Symmetric sparse factorisation and lowest modes, both checked: a wrong answer is an error, not a number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.linalg import LinAlgError, eigh
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import ArpackError, LinearOperator, SuperLU, eigsh, splu

from owt_model.errors import ComputationError

__all__ = ["Factor", "dense_modes", "factorise", "hertz", "lowest_modes"]

Modes = tuple[Float[np.ndarray, " mode"], Float[np.ndarray, "dof mode"]]
#: Pivot of the equilibrated matrix below which the factorisation has lost all digits.
_SMALLEST_PIVOT = 1e-14
#: Systems up to this size are solved densely: faster there, and every mode is within reach.
_DENSE = 300
#: Relative round-off of the lowest omega^2 from which on it is computed apart from the highest.
_LOST = 1e-4
#: Largest product in the mass of two modes that are computed apart.
_SHARED = 1e-6


@dataclass(frozen=True)
class Factor:
    """Factorised symmetric matrix, equilibrated by its diagonal."""

    lu: SuperLU
    scale: Float[np.ndarray, " dof"]

    def solve(self, right: Float[np.ndarray, "dof ..."]) -> Float[np.ndarray, "dof ..."]:
        """Solve for one or several right-hand sides."""
        scale = self.scale if right.ndim == 1 else self.scale[:, None]
        return np.asarray(scale * self.lu.solve(np.ascontiguousarray(scale * right)))

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the matrix (Sylvester's law of inertia)."""
        return int(np.count_nonzero(self.lu.U.diagonal() < 0.0))


def factorise(matrix: csc_array, *, definite: bool = True) -> Factor:
    """Factorise a symmetric matrix, pivots on the diagonal.

    Parameters
    ----------
    matrix : sparse [dof, dof]
        Symmetric; positive definite if `definite`.
    definite : bool
        Whether to refuse a matrix with a pivot that is not safely positive.

    Raises
    ------
    ComputationError
        If the matrix is singular or, where asked for, not positive definite to working accuracy.
    """
    size = matrix.shape[0]
    diagonal = matrix.diagonal()
    reference = float(np.abs(diagonal).max(initial=0.0))
    if definite and size and not diagonal.min() > 0.0:
        raise ComputationError(_singular(int(diagonal.argmin())))
    scale = 1.0 / np.sqrt(np.maximum(np.abs(diagonal), 1e-300 + 1e-30 * reference))
    scaling = diags_array(scale)
    balanced = csc_array(scaling @ matrix @ scaling)
    try:
        lu = splu(
            balanced,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # SuperLU met a pivot that is exactly zero
        raise ComputationError(_singular(None)) from None
    pivots = lu.U.diagonal()
    if definite and size and pivots.min() <= _SMALLEST_PIVOT:
        raise ComputationError(_singular(int(lu.perm_c[int(pivots.argmin())])))
    return Factor(lu, scale)


def _singular(dof: int | None) -> str:
    where = "" if dof is None else f" at degree of freedom {dof}"
    return (
        f"the stiffness matrix is singular to working accuracy{where}: the structure is a mechanism or "
        "nearly one. Check supports, connections, and sections of very different stiffness."
    )


def lowest_modes(stiffness: csc_array, mass: csc_array, count: int) -> Modes:
    """Return the `count` lowest modes of K x = omega^2 M x, mass-normalised.

    Shift-invert Lanczos about zero; then the number of modes below the highest one found is counted
    independently by the inertia of K - sigma M, so that none of a cluster can be missed.

    Returns
    -------
    omega_squared : float array [mode]
        Ascending, in rad2/s2.
    shapes : float array [dof, mode]
        shapes' M shapes = 1; the largest entry of each is positive.

    Raises
    ------
    ComputationError
        If the iteration does not converge or misses a mode.
    """
    size = stiffness.shape[0]
    if count == 0:
        return np.zeros(0), np.zeros((size, 0))
    if size <= _DENSE or 3 * count > size:
        values, shapes = dense_modes(stiffness.toarray(), mass.toarray())
        return values[:count], np.ascontiguousarray(shapes[:, :count])
    factor = factorise(stiffness)
    inverse = LinearOperator((size, size), matvec=factor.solve, dtype=np.float64)
    wanted = min(count + 6, size - 1)
    start = np.random.default_rng(20210).standard_normal(size)
    for attempt in (1, 2):
        try:
            values, shapes = eigsh(
                stiffness,
                k=wanted,
                M=mass,
                sigma=0.0,
                OPinv=inverse,
                v0=start,
                ncv=min(size, max(2 * wanted + 10, 40) * attempt),
            )
        except ArpackError as error:
            raise ComputationError(f"the eigenvalue iteration did not converge ({error})") from None
        order = np.argsort(values)
        values, shapes = values[order], shapes[:, order]
        if _none_missed(stiffness, mass, values, count):
            return values[:count], _positive(shapes[:, :count])
    raise ComputationError(f"the eigenvalue iteration missed a mode among the lowest {count}")


def _none_missed(
    stiffness: csc_array, mass: csc_array, values: Float[np.ndarray, " found"], count: int
) -> bool:
    """Whether as many eigenvalues lie below a gap above the `count`-th as were found there."""
    gaps = values[count:] / values[count - 1 : -1] - 1.0
    place = count + int(gaps.argmax())
    shift = float(np.sqrt(values[place - 1] * values[place]))
    shifted = csc_array(stiffness - shift * mass)
    return factorise(shifted, definite=False).negative_pivots == place


def dense_modes(stiffness: Float[np.ndarray, "dof dof"], mass: Float[np.ndarray, "dof dof"]) -> Modes:
    """All modes of a dense pair, ascending, mass-normalised.

    Raises
    ------
    ComputationError
        If the mass or the stiffness is not positive definite to working accuracy.
    """
    try:
        values, shapes = eigh(stiffness, mass)
    except (LinAlgError, ValueError) as error:
        raise ComputationError(f"the mass matrix is not positive definite ({error})") from None
    if len(values) and not np.finfo(float).eps * values[-1] < _LOST * values[0]:
        values, shapes = _wide(stiffness, mass, values, shapes)
    return values, _positive(shapes)


def _wide(
    stiffness: Float[np.ndarray, "dof dof"],
    mass: Float[np.ndarray, "dof dof"],
    values: Float[np.ndarray, " mode"],
    shapes: Float[np.ndarray, "dof mode"],
) -> Modes:
    """Modes of a spectrum so wide that the lowest ones drown in the round-off of the highest.

    Stiff members of next to no mass make it. The highest modes are those given; the lowest come from
    M x = K x / omega^2, whose round-off is that of the lowest.

    Raises
    ------
    ComputationError
        If the stiffness is not positive definite, or the two sets do not fit together.
    """
    try:
        flexibility, low = eigh(mass, stiffness)
    except (LinAlgError, ValueError):
        raise ComputationError(_singular(None)) from None
    flexibility, low = flexibility[::-1], low[:, ::-1]
    split = np.sqrt(flexibility[0] / max(values[-1], 1e-300))
    count = int(np.count_nonzero(flexibility > split))
    low = low[:, :count]
    low = low / np.sqrt(np.einsum("di,di->i", low, mass @ low))
    high = shapes[:, count:]
    shared = low.T @ (mass @ high)
    if np.abs(shared).max(initial=0.0) > _SHARED:
        raise ComputationError(
            "the lowest and the highest modes cannot be told apart to working accuracy: the structure has "
            "members of very different stiffness or mass. Check sections and densities."
        )
    lowest = np.einsum("di,di->i", low, stiffness @ low)
    return np.concatenate([lowest, values[count:]]), np.hstack([low, high - low @ shared])


def _positive(shapes: Float[np.ndarray, "dof mode"]) -> Float[np.ndarray, "dof mode"]:
    """Fix the open sign: the largest entry of each shape is positive."""
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
    return np.ascontiguousarray(shapes * np.where(largest < 0.0, -1.0, 1.0))


def hertz(omega_squared: Float[np.ndarray, " mode"]) -> list[float]:
    """Natural frequencies in Hz of omega^2 in rad2/s2."""
    frequency: list[float] = (np.sqrt(omega_squared) / (2.0 * np.pi)).tolist()
    return frequency
