"""Variance spectra S(f) of a sea: JONSWAP, Pierson-Moskowitz, Ochi-Hubble and Torsethaugen.

Every shape is a pure function of frequency in Hz; :data:`SHAPES` names them all as the case file does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from owt_model import sea_config
from owt_model.config import CaseConfig, SeaStateConfig
from owt_model.errors import InputError

__all__ = [
    "SHAPES",
    "System",
    "band_variance",
    "density",
    "gamma_rule",
    "jonswap",
    "most_probable_systems",
    "ochi_hubble",
    "peak_enhancement",
    "pierson_moskowitz",
    "spectral_density",
    "torsethaugen",
    "torsethaugen_systems",
]

Array = Float[np.ndarray, " frequency"]

#: Share of the variance of Hs that a band must hold: below it, the sea would be all tail.
LEAST_SHARE = 1e-6
#: The same where the band is scaled to Hs and is cut above only: below it, Hs and Tp are of another sea.
#: A Pierson-Moskowitz spectrum has 0.78 of its variance below 1.5 fp.
LEAST_SHARE_BELOW_CUTOFF = 0.75
#: Frequencies of the sum that finds it.
SHARE_FREQUENCIES = 2000


def gamma_rule(hs: float, tp: float) -> float:
    """Peak enhancement from Hs in m and Tp in s [eq. 4.80]."""
    ratio = tp / math.sqrt(hs)
    if ratio <= 3.6:
        return 5.0
    return math.exp(5.75 - 1.15 * ratio) if ratio <= 5.0 else 1.0


def pierson_moskowitz(frequency: Array, *, hs: float, tp: float) -> Array:
    """Variance density S(f) in m2/Hz of the Pierson-Moskowitz spectrum [eq. 2.36].

    The energy scale alpha g^2 (2 pi)^-4 is 5/16 Hs^2 fp^4: then 4 sqrt(m0) = Hs over all frequencies.

    Parameters
    ----------
    frequency : float array [frequency]
        Frequencies f in Hz, > 0.
    hs, tp : float
        Significant wave height in m, peak period in s.
    """
    f, f_p = frequency, 1.0 / tp
    return np.asarray(5.0 / 16.0 * hs**2 * f_p**4 * f**-5.0 * np.exp(-1.25 * (f / f_p) ** -4.0))


def _enhancement(ratio: Array, gamma: float) -> Array:
    """Peak enhancement gamma^exp(-(f/fp - 1)^2 / (2 sigma^2)) at f/fp [eq. 2.37]."""
    sigma = np.where(ratio <= 1.0, 0.07, 0.09)
    return np.asarray(gamma ** np.exp(-0.5 * ((ratio - 1.0) / sigma) ** 2))


def jonswap(frequency: Array, *, hs: float, tp: float, gamma: float) -> Array:
    """Variance density S(f) in m2/Hz of the JONSWAP spectrum [eq. 2.37].

    The energy scale is that of DNV-RP-C205, 1 - 0.287 ln gamma times that of Pierson and Moskowitz, which
    gives 4 sqrt(m0) = Hs to about a percent over all frequencies.

    Parameters
    ----------
    frequency : float array [frequency]
        Frequencies f in Hz, > 0.
    hs, tp, gamma : float
        Significant wave height in m, peak period in s, peak enhancement.
    """
    scale = 1.0 - 0.287 * math.log(gamma)
    unenhanced = pierson_moskowitz(frequency, hs=hs, tp=tp)
    return np.asarray(scale * unenhanced * _enhancement(frequency * tp, gamma))


class System(NamedTuple):
    """One of two wave systems: Hs in m, Tp in s, and lambda (Ochi-Hubble) or gamma (Torsethaugen)."""

    hs: float
    tp: float
    shape: float


def most_probable_systems(hs: float) -> tuple[System, System]:
    """Ochi and Hubble's most probable swell and wind sea of a given total Hs in m [1976, table 2b]."""
    first, second = sea_config.most_probable_systems(hs)
    return System(*first), System(*second)


def ochi_hubble(frequency: Array, *, systems: tuple[System, System]) -> Array:
    """Variance density S(f) in m2/Hz of the six-parameter spectrum of Ochi and Hubble (1976, eq. 9).

    S(w) = 1/4 sum ((4 l + 1)/4 wp^4)^l / Gamma(l) Hs^2 / w^(4 l + 1) exp(-(4 l + 1)/4 (wp/w)^4): each system
    has the variance Hs^2/16 whatever its shape l, and l = 1 is Pierson and Moskowitz.

    Parameters
    ----------
    frequency : float array [frequency]
        Frequencies f in Hz, > 0.
    systems : pair of System
        Hs, Tp and shape l of both systems.
    """
    total = np.zeros_like(frequency)
    for hs, tp, shape in systems:
        # With y = (4 l + 1)/4 (fp/f)^4, S = Hs^2/(4 f) y^l e^-y / Gamma(l); its logarithm cannot overflow.
        y = (shape + 0.25) * (frequency * tp) ** -4.0
        total += hs**2 / (4.0 * frequency) * np.exp(shape * np.log(y) - y - math.lgamma(shape))
    return np.asarray(total)


#: Constants of Torsethaugen and Haver (2004, table 1): a_f for a long fetch (370 km), a_e, a_u, a_10, a_1,
#: k_g, b_1, a_20, a_2, a_3. The periods they scale are in s, the heights in m.
A_F, A_E, A_U, A_10, A_1, K_G, B_1, A_20, A_2, A_3 = 6.6, 2.0, 25.0, 0.7, 0.5, 35.0, 2.0, 0.6, 0.3, 6.0
#: Scale G0 of f^-4 exp(-f^-4) to unit area, as printed; exactly 4 / Gamma(3/4) = 3.264.
G_0 = 3.26


def torsethaugen_systems(hs: float, tp: float, *, gravity: float) -> tuple[System, System]:
    """Primary and secondary system of a sea of Hs in m and Tp in s (Torsethaugen and Haver, 2004).

    The period A_F Hs^(1/3) of the fully developed sea decides: below it the sea is wind dominated and the
    rest is swell, above it swell dominated and the rest is wind sea. Hs1^2 + Hs2^2 = Hs^2. The shape is the
    peak enhancement; below 1, where the rule of a wind sea can fall, it is taken as 1.

    References
    ----------
    K. Torsethaugen, S. Haver, Simplified double peak spectral model for ocean waves, ISOPE 2004, paper
    2004-JSC-193; DNV-RP-C205, 3.5.5 and appendix A.
    """
    developed, shortest = A_F * hs ** (1.0 / 3.0), A_E * math.sqrt(hs)

    def enhancement(height: float, period: float) -> float:
        return K_G * math.pow(2.0 * math.pi * height / (gravity * period**2), 6.0 / 7.0)

    if tp <= developed:
        below = min(1.0, (developed - tp) / (developed - shortest))
        share = A_10 + (1.0 - A_10) * math.exp(-((below / A_1) ** 2))
        gamma, second_tp = enhancement(share * hs, tp), developed + B_1
        rest = hs * math.sqrt(1.0 - share**2)
    else:
        above = min(1.0, (tp - developed) / (A_U - developed))
        share = A_20 + (1.0 - A_20) * math.exp(-((above / A_2) ** 2))
        rest = hs * math.sqrt(1.0 - share**2)
        gamma, second_tp = enhancement(hs, developed) * (1.0 + A_3 * above), A_F * rest ** (1.0 / 3.0)
    return System(share * hs, tp, max(1.0, gamma)), System(rest, second_tp, 1.0)


def torsethaugen(frequency: Array, *, hs: float, tp: float, gravity: float) -> Array:
    """Variance density S(f) in m2/Hz of the simplified two-peak spectrum of Torsethaugen and Haver (2004).

    S = sum Hs^2 Tp / 16 G0 A_gamma n^-4 exp(-n^-4) gamma^exp(-(n - 1)^2 / (2 sigma^2)), n = f Tp, over the
    systems of :func:`torsethaugen_systems`, A_gamma = (1 + 1.1 (ln gamma)^1.19) / gamma.

    Parameters
    ----------
    frequency : float array [frequency]
        Frequencies f in Hz, > 0.
    hs, tp : float
        Significant wave height in m, peak period in s of the primary system.
    gravity : float
        m/s2.
    """
    total = np.zeros_like(frequency)
    for height, period, gamma in torsethaugen_systems(hs, tp, gravity=gravity):
        if height == 0.0:
            continue  # a fully developed sea has no second system, and that has no period
        n = frequency * period
        scale = height**2 * period / 16.0 * G_0 * (1.0 + 1.1 * math.log(gamma) ** 1.19) / gamma
        total += scale * n**-4.0 * np.exp(-(n**-4.0)) * _enhancement(n, gamma)
    return np.asarray(total)


def peak_enhancement(sea: SeaStateConfig, *, gravity: float) -> float:
    """Peak enhancement of the (primary) peak of `sea`; 0 for a spectrum that has none."""
    if sea.spectrum == "jonswap":
        return gamma_rule(sea.hs_m, sea.tp_s) if sea.gamma is None else sea.gamma
    if sea.spectrum == "torsethaugen":
        return torsethaugen_systems(sea.hs_m, sea.tp_s, gravity=gravity)[0].shape
    return 1.0 if sea.spectrum == "pierson-moskowitz" else 0.0


def _ochi_hubble_of(frequency: Array, sea: SeaStateConfig, gravity: float) -> Array:
    assert sea.wave_systems is not None
    first, second = sea.wave_systems
    return ochi_hubble(frequency, systems=(System(*first), System(*second)))


#: Density in m2/Hz at frequencies in Hz, of a sea state in gravity in m/s2: every shape of the case file.
SHAPES: Mapping[str, Callable[[Array, SeaStateConfig, float], Array]] = {
    "jonswap": lambda f, sea, g: jonswap(f, hs=sea.hs_m, tp=sea.tp_s, gamma=peak_enhancement(sea, gravity=g)),
    "pierson-moskowitz": lambda f, sea, _: pierson_moskowitz(f, hs=sea.hs_m, tp=sea.tp_s),
    "ochi-hubble": _ochi_hubble_of,
    "torsethaugen": lambda f, sea, g: torsethaugen(f, hs=sea.hs_m, tp=sea.tp_s, gravity=g),
}


def density(sea: SeaStateConfig, frequency: Array, *, gravity: float) -> Array:
    """Variance density in m2/Hz of `sea` at frequencies in Hz, > 0, as its formula gives it.

    Neither the band nor ``scale`` enters: see :func:`spectral_density` for the sea that is realised.
    """
    return SHAPES[sea.spectrum](frequency, sea, gravity)


def band_variance(
    sea: SeaStateConfig, *, duration: float, gravity: float
) -> tuple[Array, Float[np.ndarray, " frequency"]]:
    """Frequencies in Hz of the components of `sea` in a record of `duration` s, and the variance of each.

    It is S df [eq. 4.7], in m2. With scale ``band`` the variances add up to Hs^2/16 exactly; with ``formula``
    they are what the formula gives.

    Raises
    ------
    InputError
        If the band holds no component, or next to nothing of the spectrum; with scale ``band`` and no cut-in
        also if less than 0.75 of the spectrum's variance lies below the cut-off.
    """
    numbers = sea.component_numbers(duration=duration, gravity=gravity)
    f = np.arange(numbers.start, numbers.stop) / duration
    variance = density(sea, f, gravity=gravity) / duration
    total, wanted = float(np.sum(variance)), sea.hs_m**2 / 16.0
    band = f"from {f[0]:.3g} to {f[-1]:.3g} Hz"
    if not total >= LEAST_SHARE * wanted:
        raise _narrow(sea, f"leaves {total / wanted:.1g} of the energy of Hs in the band {band}")
    if sea.scale == "band" and sea.cutin_over_peak == 0.0:
        share = _share_below(sea, sea.cutoff_hz(gravity), gravity=gravity)
        if share < LEAST_SHARE_BELOW_CUTOFF:
            least = f"less than {LEAST_SHARE_BELOW_CUTOFF:g}"
            raise _narrow(sea, f"leaves {share:.2g} of the energy of Hs in the band {band}, {least}")
    return f, variance * (wanted / total) if sea.scale == "band" else variance


def _share_below(sea: SeaStateConfig, highest: float, *, gravity: float) -> float:
    """Variance of `sea` below a frequency in Hz over Hs^2/16, however few components lie there."""
    step = highest / SHARE_FREQUENCIES
    f = (np.arange(SHARE_FREQUENCIES) + 0.5) * step
    return float(np.sum(density(sea, f, gravity=gravity))) * step * 16.0 / sea.hs_m**2


def _narrow(sea: SeaStateConfig, what: str) -> InputError:
    """The refusal of a band that leaves the spectrum out."""
    remedy = "Widen the band to where the spectrum lies"
    if sea.cutoff == "steepness":
        return InputError("sea_state.cutoff", sea.cutoff, what, f"{remedy}, with cutoff over_peak.")
    return InputError("sea_state.cutoff_over_peak", sea.cutoff_over_peak, what, f"{remedy}.")


def spectral_density(case: CaseConfig) -> tuple[Array, Float[np.ndarray, " frequency"]]:
    """Frequencies in Hz and variance density in m2/Hz of the sea state of `case`, as it is realised.

    At the components of the record, within the band, with the scale of the case. Rayleigh amplitudes and a
    focused crest are drawn about this.

    Raises
    ------
    InputError
        If the sea of the case is not a spectrum, or its band holds none of it.
    """
    if case.sea_state is None:
        raise InputError(
            "sea_state", None, "is needed: this sea is not given by a spectrum", "Give a sea state."
        )
    duration = case.time.duration_s
    f, variance = band_variance(case.sea_state, duration=duration, gravity=case.gravity_m_s2)
    return f, variance * duration
