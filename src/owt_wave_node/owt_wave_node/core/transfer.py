"""Second-order transfer functions of two components that travel in one direction [eq. 4.13-4.19]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_wave_node.core.sea import Waves
from owt_wave_node.kernels import spectra as _pairs
from owt_wave_node.kernels import transfer as _kernel
from owt_wave_node.kernels.simd import ROWS

__all__ = ["PairTables", "Transfer", "pair_tables", "set_down", "transfer"]


@dataclass(frozen=True)
class Transfer:
    """Transfer functions of all pairs (m, n) of a set of components.

    D- of a component with itself is 0: a choice of the Bernoulli constant. B- of a component with itself is
    then -k / (2 sinh 2 k d), the mean set-down.
    """

    d_plus: Float[np.ndarray, "m n"]  # rad2/m2
    d_minus: Float[np.ndarray, "m n"]  # rad2/m2
    b_plus: Float[np.ndarray, "m n"]  # 1/m
    b_minus: Float[np.ndarray, "m n"]  # 1/m


def transfer(
    omega: Float[np.ndarray, " m"],
    wavenumber: Float[np.ndarray, " m"],
    *,
    water_depth: float,
    gravity: float,
) -> Transfer:
    """Evaluate D+, D- [eq. 4.14, 4.13] and B+, B- [eq. 4.19, corrected] for every pair of components.

    Parameters
    ----------
    omega, wavenumber : float arrays [component]
        rad/s and rad/m, related by the dispersion relation.
    water_depth, gravity : float
        m, m/s2.
    """
    size = omega.size
    out = np.empty((4, size, size))
    for m in range(size):
        for n in range(size):
            out[:, m, n] = _kernel.transfer_pair(
                wavenumber[m], wavenumber[n], omega[m], omega[n], water_depth, gravity
            )
    return Transfer(*out)


def set_down(waves: Waves) -> float:
    """Mean of the second-order elevation in m: -sum |a|^2 k / (2 sinh 2 k d) [j = 0 of eq. 4.45]."""
    q = np.exp(-2.0 * waves.wavenumber * waves.depth)
    return -float(np.sum(np.abs(waves.amplitude) ** 2 * waves.wavenumber * q / (1.0 - q * q)))


@dataclass(frozen=True)
class PairTables:
    """Packed factors of all pairs, see :mod:`owt_wave_node.kernels.transfer`."""

    velocity_sum: Float[np.ndarray, " pair"]
    velocity_difference: Float[np.ndarray, " other"]
    surface_sum: Float[np.ndarray, " pair"]
    surface_difference: Float[np.ndarray, " other"]

    def spaced(self, size: int) -> PairTables:
        """Return the same for `size` components, with the gaps between rows that the pair sums want."""

        def space(packed: Float[np.ndarray, " pair"], shortest: int) -> Float[np.ndarray, " entry"]:
            rows = size + ROWS
            out = np.zeros(rows * (rows + 1) // 2 + _pairs.GAP * (rows + 1))
            _pairs.spaced(packed, size, shortest, out)
            return out

        return PairTables(
            space(self.velocity_sum, 1),
            space(self.velocity_difference, 0),
            space(self.surface_sum, 1),
            space(self.surface_difference, 0),
        )


def pair_tables(waves: Waves) -> PairTables:
    """Evaluate the factors of every pair m >= n of `waves`."""
    size = waves.omega.size
    sums, differences = size * (size + 1) // 2, size * (size - 1) // 2
    tables = PairTables(np.empty(sums), np.empty(differences), np.empty(sums), np.empty(differences))
    _kernel.tables(
        waves.wavenumber,
        waves.omega,
        waves.depth,
        waves.gravity,
        tables.velocity_sum,
        tables.velocity_difference,
        tables.surface_sum,
        tables.surface_difference,
    )
    return tables
