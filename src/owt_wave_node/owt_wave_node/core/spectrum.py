"""JONSWAP spectrum and its realisation by components with random phases."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["components", "gamma_rule", "jonswap", "phases"]

Array = Float[np.ndarray, " component"]


def gamma_rule(hs: float, tp: float) -> float:
    """Peak enhancement from Hs in m and Tp in s [eq. 4.80]."""
    ratio = tp / math.sqrt(hs)
    if ratio <= 3.6:
        return 5.0
    return math.exp(5.75 - 1.15 * ratio) if ratio <= 5.0 else 1.0


def jonswap(frequency: Array, *, hs: float, tp: float, gamma: float) -> Array:
    """Variance density S(f) in m2/Hz of the JONSWAP spectrum [eq. 2.37].

    The energy scale is that of DNV-RP-C205, (1 - 0.287 ln gamma) 5/16 Hs^2 fp^4, which gives
    4 sqrt(m0) = Hs to about a percent over all frequencies; :func:`components` normalises exactly.

    Parameters
    ----------
    frequency : float array [component]
        Frequencies f in Hz, > 0.
    hs, tp, gamma : float
        Significant wave height in m, peak period in s, peak enhancement.
    """
    f, f_p = frequency, 1.0 / tp
    sigma = np.where(f <= f_p, 0.07, 0.09)
    peak = np.exp(-((f - f_p) ** 2) / (2.0 * sigma**2 * f_p**2))
    scale = (1.0 - 0.287 * math.log(gamma)) * 5.0 / 16.0 * hs**2 * f_p**4
    return np.asarray(scale * f**-5.0 * np.exp(-1.25 * (f / f_p) ** -4.0) * gamma**peak)


def phases(count: int, seed: int) -> Array:
    """Phases in rad, uniform in (0, 2 pi), of components 1 to `count`.

    They are ``2 pi * numpy.random.Generator(numpy.random.PCG64(seed)).random(count)``, in ascending
    frequency: PCG64 and its conversion to doubles are fixed, so that a seed gives the same sea everywhere,
    and a longer band begins with the phases of a shorter one.
    """
    return 2.0 * math.pi * np.random.Generator(np.random.PCG64(seed)).random(count)


def components(
    *, hs: float, tp: float, gamma: float, cutoff_over_peak: float, duration: float, seed: int
) -> tuple[Array, Array, Array]:
    """Realise a JONSWAP sea: frequencies in rad/s, amplitudes in m, phases in rad.

    omega_m = m 2 pi / duration, m = 1, 2, ... up to cutoff_over_peak * 2 pi / tp. The amplitudes are
    deterministic, sqrt(2 S df) [eq. 4.7], scaled so that 4 sqrt(sum a^2 / 2) is Hs exactly: the spectrum is
    normalised within its band.

    Raises
    ------
    InputError
        If no component lies in the band.
    """
    cutoff = cutoff_over_peak / tp
    count = math.floor(cutoff * duration * (1.0 + 1e-12))
    if count < 1:
        raise InputError(
            "time.n",
            f"{duration:g} s",
            f"is too short: no component lies below the cut-off {2.0 * math.pi * cutoff:.3g} rad/s",
            "Use a longer record.",
        )
    f = np.arange(1, count + 1) / duration
    amplitude = np.sqrt(2.0 * jonswap(f, hs=hs, tp=tp, gamma=gamma) / duration)
    amplitude *= hs / (4.0 * math.sqrt(0.5 * float(np.sum(amplitude**2))))
    return 2.0 * math.pi * f, amplitude, phases(count, seed)
