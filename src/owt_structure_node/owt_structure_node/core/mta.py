"""Modal truncation augmentation vectors of any order (thesis 3.6.2 and 3.7).

Of the loads F and, on request, of the interface accelerations Y,

    P (K^-1 M)^j K^-1 [Y F],   j = 0 ... m,   P = I - Phi Phi' M        [eq. 3.53]

Each order is made from the orthonormal vectors of the one before, which span the same space as the powers
and keep their digits. Vectors that depend on the modes or on each other are left out and counted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.sparse import csc_array

from owt_structure_node.core.modes import Factor

__all__ = ["Augmentation", "augment", "independent"]

#: Share of its energy that a vector must keep beside modes and earlier vectors to count as independent.
INDEPENDENT = 1e-12
#: Static energy of a load vector, relative to the largest of all, below which it loads nothing.
LOADED = 1e-20


@dataclass(frozen=True)
class Augmentation:
    """Augmentation vectors, and what was left out.

    Attributes
    ----------
    sigma_squared : float array [vector]
        Squares of the pseudo-frequencies [eq. 3.42], ascending, in rad2/s2.
    vectors : float array [internal, vector]
        Orthonormal as eq. 3.44: V' M V = 1, V' K V = sigma^2, Phi' M V = 0.
    unloaded : int
        Load vectors that do not load the inside of the jacket.
    dependent : int
        Vectors that depend on modes or on other vectors.
    """

    sigma_squared: Float[np.ndarray, " vector"]
    vectors: Float[np.ndarray, "internal vector"]
    unloaded: int
    dependent: int


def augment(
    factor: Factor,
    stiffness: csc_array,
    mass: csc_array,
    modes: Float[np.ndarray, "internal mode"],
    loads: Float[np.ndarray, "internal load"],
    order: int = 0,
) -> Augmentation:
    """Augmentation vectors of orders 0 to `order` [eq. 3.53], made orthonormal [eq. 3.42-3.44].

    Parameters
    ----------
    factor : Factor
        Of the internal stiffness.
    stiffness, mass : sparse [internal, internal]
        K_ii and M_ii.
    modes : float array [internal, mode]
        Fixed-interface modes, mass-normalised, to which the vectors are made orthogonal.
    loads : float array [internal, load]
        Load vectors, the most important first: of two that depend on each other the later one goes.
    order : int
        Highest order j.
    """
    static = factor.solve(loads)
    energy = np.einsum("dv,dv->v", loads, static)
    loaded = energy > LOADED * energy.max(initial=0.0)
    candidates = static[:, loaded] / np.sqrt(energy[loaded])
    accepted = np.zeros((len(static), 0))
    fresh, dependent = 0, 0
    for j in range(order + 1):
        if j:
            before = accepted[:, accepted.shape[1] - fresh :]
            candidates = factor.solve(np.asarray(mass @ before))
        found = independent(candidates, stiffness, mass, modes, accepted)
        fresh = found.shape[1]
        dependent += candidates.shape[1] - fresh
        accepted = np.hstack([accepted, found])
    # The flexible end of the pencil is the interesting one; V' K V = 1 here: solve M y = (1/sigma^2) y.
    small = accepted.T @ (mass @ accepted)
    inverse, y = np.linalg.eigh(0.5 * (small + small.T))
    inverse, y = inverse[::-1], y[:, ::-1]
    vectors = np.ascontiguousarray(accepted @ (y / np.sqrt(inverse)))
    return Augmentation(1.0 / inverse, vectors, int((~loaded).sum()), dependent)


def independent(
    candidates: Float[np.ndarray, "internal candidate"],
    stiffness: csc_array,
    mass: csc_array,
    modes: Float[np.ndarray, "internal mode"],
    accepted: Float[np.ndarray, "internal accepted"],
) -> Float[np.ndarray, "internal fresh"]:
    """What candidates add to modes and to accepted vectors: orthonormal in K, M-orthogonal to the modes.

    Gram and Schmidt, one candidate after the other and each twice, so that orthogonality holds to round-off.
    A candidate that keeps less than :data:`INDEPENDENT` of its energy is left out.
    """
    basis = accepted
    first = accepted.shape[1]
    for i in range(candidates.shape[1]):
        v = candidates[:, i]
        before = float(v @ (stiffness @ v))
        for _ in range(2):
            v = v - modes @ (modes.T @ (mass @ v))
            v = v - basis @ (basis.T @ (stiffness @ v))
        energy = float(v @ (stiffness @ v))
        if energy > INDEPENDENT * before > 0.0:
            basis = np.hstack([basis, v[:, None] / np.sqrt(energy)])
    return np.ascontiguousarray(basis[:, first:])
