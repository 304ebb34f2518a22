"""Exceedance of crest heights: counted in a record, and by the distributions of first and second order.

Sources: Longuet-Higgins (1952) for Rayleigh; Tayfun (1980), J. Geophys. Res. 85, 1548-1552;
Forristall (2000), J. Phys. Oceanogr. 30, 1931-1943, as given in DNV-RP-C205 section 3.5.10.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

__all__ = ["counted_exceedance", "forristall_crest", "forristall_shape", "rayleigh_crest", "tayfun_crest"]

Probability = Float[np.ndarray, " p"]
Height = Float[np.ndarray, " p"]


def counted_exceedance(crest: Float[np.ndarray, " wave"]) -> tuple[Height, Probability]:
    """Crests in descending order, and the share i / (n + 1) of waves that reach each (Weibull's rule)."""
    height = np.sort(crest)[::-1].copy()
    return height, np.arange(1, height.size + 1) / (height.size + 1.0)


def rayleigh_crest(probability: Probability, *, hs: float) -> Height:
    """Crest in m that a wave of a linear narrow-banded sea exceeds: P = exp(-8 c^2 / Hs^2)."""
    return np.asarray(hs * np.sqrt(-np.log(probability) / 8.0))


def tayfun_crest(probability: Probability, *, hs: float, wavenumber: float) -> Height:
    """Crest in m of a narrow-banded second-order sea in deep water: c = xi + k xi^2 / 2, xi Rayleigh.

    Parameters
    ----------
    probability : float array [p]
    hs, wavenumber : float
        Hs in m and the wave number in rad/m of the mean frequency.
    """
    linear = rayleigh_crest(probability, hs=hs)
    return np.asarray(linear + 0.5 * wavenumber * linear**2)


def forristall_shape(
    *, hs: float, tm01: float, wavenumber: float, depth: float, gravity: float, spread: bool = False
) -> tuple[float, float]:
    """Scale alpha and exponent beta of Forristall's second-order crests: P = exp(-(c / (alpha Hs))^beta).

    They depend on the steepness S1 = 2 pi Hs / (g T1^2) and the Ursell number Ur = Hs / (k1^2 d^3).

    Parameters
    ----------
    hs, tm01 : float
        Hs in m, mean period T1 = m0/m1 in s.
    wavenumber, depth, gravity : float
        Wave number k1 of T1 in rad/m, depth in m, gravity in m/s2.
    spread : bool
        Short-crested (3D) instead of long-crested (2D) fit.
    """
    s1 = 2.0 * math.pi * hs / (gravity * tm01**2)
    ursell = hs / (wavenumber**2 * depth**3)
    if spread:
        alpha = 0.3536 + 0.2568 * s1 + 0.0800 * ursell
        return alpha, 2.0 - 1.7912 * s1 - 0.5302 * ursell + 0.284 * ursell**2
    return 0.3536 + 0.2892 * s1 + 0.1060 * ursell, 2.0 - 2.1597 * s1 + 0.0968 * ursell**2


def forristall_crest(probability: Probability, *, hs: float, alpha: float, beta: float) -> Height:
    """Crest in m that a wave exceeds with `probability`, from the shape of :func:`forristall_shape`."""
    return np.asarray(alpha * hs * (-np.log(probability)) ** (1.0 / beta))
