"""Damage of a stationary Gaussian stress from its spectrum: narrow band (Rayleigh) and Dirlik (1985).

Both take ranges of cycles to be a mixture of Weibull distributions, so that the expected damage of an S-N
curve of two slopes is a sum of incomplete gamma functions, without an integral over ranges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.special import gamma, gammainc, gammaincc

from owt_model.errors import InputError
from owt_postproc.core.sn_curve import SNCurve

__all__ = ["SpectralMoments", "dirlik_damage", "narrow_band_damage", "spectral_moments"]

#: Irregularity from which a process is taken as narrow band, where Dirlik's weights become 0/0.
NARROW = 1.0 - 1e-6


@dataclass(frozen=True)
class SpectralMoments:
    """Moments of a one-sided spectrum over frequency f in Hz, m_n the integral of f^n S(f)."""

    m0: float
    m1: float
    m2: float
    m4: float

    @property
    def crossing_hz(self) -> float:
        """Upward crossings of the mean per s, sqrt(m2/m0)."""
        return float(np.sqrt(self.m2 / self.m0))

    @property
    def peak_hz(self) -> float:
        """Maxima per s, sqrt(m4/m2)."""
        return float(np.sqrt(self.m4 / self.m2))

    @property
    def irregularity(self) -> float:
        """Crossings over maxima, m2/sqrt(m0 m4): 1 for a narrow band, towards 0 for a broad one."""
        return float(self.m2 / np.sqrt(self.m0 * self.m4))


def spectral_moments(frequency: Float[np.ndarray, " f"], density: Float[np.ndarray, " f"]) -> SpectralMoments:
    """Moments of a one-sided spectrum, by the trapezoidal rule.

    Parameters
    ----------
    frequency : float array [f]
        Rising, in Hz.
    density : float array [f]
        In (unit of the series)^2/Hz.

    Raises
    ------
    InputError
        If there are fewer than two frequencies, they do not rise, or the density is negative, not finite or
        zero everywhere.
    """
    if len(frequency) < 2 or len(frequency) != len(density) or not (np.diff(frequency) > 0.0).all():
        raise InputError(
            "frequency", frequency, "must be two or more rising values, one a density", "Sort it."
        )
    if not (np.isfinite(density) & (density >= 0.0)).all() or not (density > 0.0).any() or frequency[0] < 0.0:
        raise InputError("density", density, "must be finite, >= 0, and not zero everywhere", "Check it.")
    return SpectralMoments(*(float(np.trapezoid(frequency**n * density, frequency)) for n in (0, 1, 2, 4)))


def narrow_band_damage(
    moments: SpectralMoments, duration_s: float, curve: SNCurve, *, thickness_m: float | None = None
) -> float:
    """Expected damage of a narrow band: every crossing is a cycle, ranges have Rayleigh's distribution.

    An upper bound in practice for broader spectra, the more so the broader they are.

    Parameters
    ----------
    moments : SpectralMoments
        Of the stress in Pa.
    duration_s : float
    curve : SNCurve
    thickness_m : float, optional
        Of the wall; without it not thicker than the curve's reference.

    Notes
    -----
    For one slope: D = nu T / a (2 sqrt(2 m0))^m Gamma(1 + m/2), nu = sqrt(m2/m0).
    """
    scale = 2.0 * np.sqrt(2.0 * moments.m0)
    per_cycle = _weibull_damage(curve, thickness_m, scale, 2.0)
    return float(moments.crossing_hz * duration_s * per_cycle)


def dirlik_damage(
    moments: SpectralMoments, duration_s: float, curve: SNCurve, *, thickness_m: float | None = None
) -> float:
    """Expected damage by Dirlik's distribution of rainflow ranges (1985).

    Parameters as of :func:`narrow_band_damage`, to which it turns at an irregularity of 1. It hangs on m4,
    and so on the highest frequency of the spectrum: give it to where the stress ends, and no noise.
    """
    g = moments.irregularity
    if g > NARROW:
        return narrow_band_damage(moments, duration_s, curve, thickness_m=thickness_m)
    x = moments.m1 / moments.m0 * np.sqrt(moments.m2 / moments.m4)
    d1 = 2.0 * (x - g**2) / (1.0 + g**2)
    r = (g - x - d1**2) / (1.0 - g - d1 + d1**2)
    d2 = (1.0 - g - d1 + d1**2) / (1.0 - r)
    q = 1.25 * (g - (1.0 - d1 - d2) - d2 * r) / d1
    unit = 2.0 * np.sqrt(moments.m0)
    per_cycle = (
        d1 * _weibull_damage(curve, thickness_m, unit * q, 1.0)
        + d2 * _weibull_damage(curve, thickness_m, unit * np.sqrt(2.0) * abs(r), 2.0)
        + (1.0 - d1 - d2) * _weibull_damage(curve, thickness_m, unit * np.sqrt(2.0), 2.0)
    )
    return float(moments.peak_hz * duration_s * per_cycle)


def _weibull_damage(curve: SNCurve, thickness_m: float | None, scale: float, shape: float) -> float:
    """Expected damage of a cycle whose range exceeds S with the probability exp(-(S/scale)^shape)."""
    knee, inverse_1, m_1, inverse_2, m_2 = (
        curve.coefficients if thickness_m is None else curve.coefficients_for(thickness_m)
    )
    if not scale > 0.0:
        return 0.0
    at_knee = (knee / scale) ** shape
    k_1, k_2 = 1.0 + m_1 / shape, 1.0 + m_2 / shape
    above = inverse_1 * scale**m_1 * gamma(k_1) * gammaincc(k_1, at_knee)
    below = inverse_2 * scale**m_2 * gamma(k_2) * gammainc(k_2, at_knee)
    return float(above + below)
