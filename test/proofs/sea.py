"""Spectra of the sea: moments, peaks, heights, values of a second code."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from owt_model.config import SeaStateConfig, parse_case
from owt_wave_node.core import spectrum
from owt_wave_node.core.realisation import realise
from proofs.registry import Proof

Shape = Callable[..., np.ndarray]
HS, TP, G = 6.0, 9.45, 9.81
#: Quadrature in ln f by the trapezoidal rule, which converges faster than any power for these shapes.
LOG_F = np.linspace(math.log(0.01 / TP), math.log(1e6 / TP), 40001)
F = np.exp(LOG_F)


def moment(density: np.ndarray, n: float) -> float:
    """Integral of f^n S(f) over the frequencies F."""
    return float(np.trapezoid(F ** (n + 1) * density, LOG_F))


def sea_of(**given: object) -> SeaStateConfig:
    sea = parse_case({"sea_state": {"hs_m": HS, "tp_s": TP} | given}).sea_state
    assert sea is not None
    return sea


def pm_moments(shape: Shape) -> float:
    """Largest relative error of m-1, m0, m1, m2: m_n = Hs^2/16 fp^n (5/4)^(n/4) Gamma(1 - n/4)."""
    s = shape(F, hs=HS, tp=TP)
    exact = {n: HS**2 / 16 * TP**-n * 1.25 ** (n / 4) * math.gamma(1 - n / 4) for n in (-1, 0, 1, 2)}
    return max(abs(moment(s, n) / value - 1) for n, value in exact.items())


def jonswap_peak(shape: Shape) -> float:
    """Largest relative error at fp (1, 1 - 0.07, 1 + 0.09): A PM gamma^1 and A PM gamma^exp(-1/2)."""
    worst = 0.0
    for gamma in (1.0, 3.3, 7.0):
        f = np.array([1.0, 0.93, 1.09]) / TP
        power = np.array([1.0, math.exp(-0.5), math.exp(-0.5)])
        pm = 5 / 16 * HS**2 / TP**4 / f**5 * np.exp(-1.25 / (f * TP) ** 4)
        exact = (1 - 0.287 * math.log(gamma)) * pm * gamma**power
        worst = max(worst, float(np.abs(shape(f, hs=HS, tp=TP, gamma=gamma) / exact - 1).max()))
    return worst


def jonswap_height(shape: Shape) -> float:
    """Largest relative error of 4 sqrt(m0) for gamma 1 to 7."""
    heights = [4 * math.sqrt(moment(shape(F, hs=HS, tp=TP, gamma=g), 0)) for g in (1.0, 2.0, 3.3, 5.0, 7.0)]
    return max(abs(height / HS - 1) for height in heights)


def one_sigma(f: np.ndarray, *, hs: float, tp: float, gamma: float) -> np.ndarray:
    """JONSWAP with sigma 0.07 on both sides of the peak."""
    below = spectrum.jonswap(np.minimum(f, 2 / tp - f), hs=hs, tp=tp, gamma=gamma)
    pm = [spectrum.pierson_moskowitz(x, hs=hs, tp=tp) for x in (f, np.minimum(f, 2 / tp - f))]
    return np.asarray(below * pm[0] / pm[1])


SYSTEMS = (spectrum.System(5.0, 12.0, 3.0), spectrum.System(3.0, 7.0, 1.0))


def ochi_hubble(shape: Shape) -> float:
    """Of each system and of both: variance, place of the peak; and shape 1 against Pierson and Moskowitz."""
    errors = []
    none = spectrum.System(0.0, 1.0, 1.0)
    for system in SYSTEMS:
        s = shape(F, systems=(system, none))
        errors.append(4 * math.sqrt(moment(s, 0)) / system.hs - 1)
        # At the peak the logarithmic slope vanishes.
        f = (1 + np.array([-1e-5, 1e-5])) / system.tp
        low, high = shape(f, systems=(system, none))
        errors.append((math.log(high) - math.log(low)) / 2e-5)
    pm = spectrum.pierson_moskowitz(F[F > 0.02], hs=3.0, tp=7.0)
    errors.append(np.abs(shape(F[F > 0.02], systems=(SYSTEMS[1], none)) - pm).max() / pm.max())
    errors.append(4 * math.sqrt(moment(shape(F, systems=SYSTEMS), 0)) / math.hypot(5.0, 3.0) - 1)
    return float(np.abs(errors).max())


def gamma_spectrum(f: np.ndarray, systems: tuple[spectrum.System, ...], add: float, of: float) -> np.ndarray:
    """Ochi and Hubble's form with `add` for 1/4 in (4 l + 1)/4, and Gamma(l + `of`)."""
    total = np.zeros_like(f)
    for hs, tp, shape in systems:
        y = (shape + add) * (f * tp) ** -4.0
        total += hs**2 / (4 * f) * np.exp(shape * np.log(y) - y - math.lgamma(shape + of))
    return total


#: S(omega) in m2 s/rad of the public library waveresponse 1.4.1 at OMEGA in rad/s, g = 9.80665 m/s2.
OMEGA = np.array([0.3, 0.45, 0.6, 0.665, 0.8, 1.0, 1.5, 2.5])
TORSETHAUGEN = {
    (6.0, 9.45): [
        0.1228560940487403, 1.6531336459167152, 4.03075484757337, 6.212110986262804,
        2.5868450335115867, 1.2986269400594705, 0.29617445761765476, 0.03959206979605911,
    ],
    (3.0, 14.0): [
        0.054511254174780505, 2.112944717077402, 0.5731053919828465, 0.5914915857976717,
        0.5167378538769039, 0.30960059507499355, 0.07658315646634803, 0.010426357157126554,
    ],
    (4.0, 7.0): [
        0.00674546978616205, 0.7794129146988547, 0.7834695814817962, 0.7907068796514509,
        1.1037557398675628, 1.0692789460608831, 0.24221266463481195, 0.03468245006327077,
    ],
    (2.0, 20.0): [
        0.7756655971977908, 0.09434667825882835, 0.10780506725109706, 0.1752939186162454,
        0.2459269533219195, 0.18573136001589763, 0.051819516739046736, 0.007233778616741119,
    ],
}  # fmt: skip
#: The same of its Ochi-Hubble systems 5.04 m, 11.83 s, 3.0 and 3.24 m, 6.9 s, 1.06 together.
OCHI_HUBBLE = np.array([
    4.686026315286863e-09, 3.2282089422159688, 5.7505191642115925, 3.148238682661096,
    1.3972450174968318, 1.0275736032678369, 0.24276301944206133, 0.01947509097633401,
])  # fmt: skip


def against_waveresponse(shape: Shape) -> float:
    """Largest relative difference to the values of the other implementation, wind seas and swell."""
    f = OMEGA / (2 * math.pi)
    return max(
        float(np.abs(shape(f, hs=hs, tp=tp, gravity=9.80665) / (2 * math.pi) / np.array(values) - 1).max())
        for (hs, tp), values in TORSETHAUGEN.items()
    )


def ochi_hubble_against_waveresponse(shape: Shape) -> float:
    systems = (spectrum.System(5.04, 11.83, 3.0), spectrum.System(3.24, 6.9, 1.06))
    found = shape(OMEGA / (2 * math.pi), systems=systems) / (2 * math.pi)
    return float(np.abs(found / OCHI_HUBBLE - 1).max())


def primary(f: np.ndarray, *, hs: float, tp: float, gravity: float, all_of_it: bool) -> np.ndarray:
    """The primary system alone, with its own energy or with all of it."""
    system = spectrum.torsethaugen_systems(hs, tp, gravity=gravity)[0]
    n, gamma = f * tp, system.shape
    enhancement = gamma ** np.exp(-0.5 * ((n - 1) / np.where(n <= 1, 0.07, 0.09)) ** 2)
    a = 3.26 * (1 + 1.1 * math.log(gamma) ** 1.19) / gamma
    height = hs if all_of_it else system.hs
    return np.asarray(height**2 * tp / 16 * a * n**-4.0 * np.exp(-(n**-4.0)) * enhancement)


def heights_add(systems: Callable[..., tuple[spectrum.System, spectrum.System]]) -> float:
    """Largest relative error of Hs1^2 + Hs2^2 = Hs^2 over seas of 0.5 to 15 m and 3 to 25 s."""
    return max(
        abs(math.hypot(*(s.hs for s in systems(hs, tp, gravity=G))) / hs - 1)
        for hs in (0.5, 2.0, 6.0, 15.0)
        for tp in (3.0, 6.0, 9.0, 14.0, 25.0)
    )


def linear_split(hs: float, tp: float, *, gravity: float) -> tuple[spectrum.System, spectrum.System]:
    """Heights that add up, where the energies should."""
    first, second = spectrum.torsethaugen_systems(hs, tp, gravity=gravity)
    return first, second._replace(hs=hs - first.hs)


def torsethaugen_height(shape: Shape) -> float:
    """Largest relative error of 4 sqrt(m0), peak enhancements 1 to 10."""
    return max(
        abs(4 * math.sqrt(moment(shape(F, hs=hs, tp=tp, gravity=G), 0)) / hs - 1)
        for hs, tp in [*TORSETHAUGEN, (8.0, 9.0), (1.0, 4.0)]
    )


def band_height(scale: str) -> float:
    """Largest relative error of 4 sqrt(sum a^2 / 2) over all shapes and two bands."""
    return max(
        abs(4 * math.sqrt(np.sum(realised.amplitude**2) / 2) / HS - 1)
        for name in spectrum.SHAPES
        for cutoff in (1.5, 4.0)
        for tp in [11.83 if name == "ochi-hubble" else TP]  # the peak of its most probable systems
        for state in [sea_of(spectrum=name, tp_s=tp, scale=scale, cutoff_over_peak=cutoff)]
        for realised in [realise(state, duration=600.0, gravity=G)]
    )


PROOFS = (
    Proof(
        "pierson-moskowitz-moments",
        "Pierson-Moskowitz has its moments m-1 to m2",
        "Hs^2/16 fp^n (5/4)^(n/4) Gamma(1 - n/4)",
        pm_moments,
        spectrum.pierson_moskowitz,
        {
            "exp(-(f/fp)^-4)": lambda f, **p: 5 / 16 * HS**2 / TP**4 / f**5 * np.exp(-1 / (f * TP) ** 4),
            "tail f^-4": lambda f, **p: spectrum.pierson_moskowitz(f, **p) * f * TP,
        },
        1e-9,
        "truncation of the tail of m2 at 1e6 fp and round-off",
    ),
    Proof(
        "jonswap-peak",
        "JONSWAP peak and its width on either side",
        "values of eq. 2.37 at fp, 0.93 fp and 1.09 fp",
        jonswap_peak,
        spectrum.jonswap,
        {"sigma 0.07 on both sides": one_sigma},
        1e-12,
        "round-off",
    ),
    Proof(
        "jonswap-height",
        "JONSWAP as printed has the height Hs, gamma 1 to 7",
        "4 sqrt(m0) by quadrature",
        jonswap_height,
        spectrum.jonswap,
        {
            "without 1 - 0.287 ln gamma": lambda f, *, gamma, **p: (
                spectrum.jonswap(f, gamma=gamma, **p) / (1 - 0.287 * math.log(gamma))
            )
        },
        0.01,
        "accuracy of the factor 1 - 0.287 ln gamma",
    ),
    Proof(
        "ochi-hubble",
        "Ochi-Hubble systems have their heights and peaks; shape 1 is Pierson-Moskowitz",
        "closed forms",
        ochi_hubble,
        spectrum.ochi_hubble,
        {
            "l for (4 l + 1)/4": lambda f, systems: gamma_spectrum(f, systems, 0.0, 0.0),
            "Gamma(l + 1)": lambda f, systems: gamma_spectrum(f, systems, 0.25, 1.0),
        },
        1e-7,
        "difference quotient at the peak",
    ),
    Proof(
        "ochi-hubble-second-code",
        "Ochi-Hubble spectrum of given systems",
        "waveresponse 1.4.1",
        ochi_hubble_against_waveresponse,
        spectrum.ochi_hubble,
        {"l for (4 l + 1)/4": lambda f, systems: gamma_spectrum(f, systems, 0.0, 0.0)},
        1e-12,
        "round-off",
    ),
    Proof(
        "torsethaugen-second-code",
        "simplified Torsethaugen spectrum, wind sea and swell dominated",
        "waveresponse 1.4.1",
        against_waveresponse,
        spectrum.torsethaugen,
        {
            "one system with all the energy": lambda f, **p: primary(f, all_of_it=True, **p),
            "g = 9.81 for 9.80665": lambda f, *, gravity, **p: spectrum.torsethaugen(f, gravity=9.81, **p),
        },
        1e-12,
        "round-off",
    ),
    Proof(
        "torsethaugen-split",
        "energies of both Torsethaugen systems add up",
        "Hs1^2 + Hs2^2 = Hs^2",
        heights_add,
        spectrum.torsethaugen_systems,
        {"heights add up": linear_split},
        1e-14,
        "round-off",
    ),
    Proof(
        "torsethaugen-height",
        "Torsethaugen as printed has the height Hs",
        "4 sqrt(m0) by quadrature",
        torsethaugen_height,
        spectrum.torsethaugen,
        {"secondary system left out": lambda f, **p: primary(f, all_of_it=False, **p)},
        0.015,
        "accuracy of A_gamma as published: 1.3 % of Hs at gamma 2",
    ),
    Proof(
        "height-in-the-band",
        "4 sqrt(m0) of the components is Hs, every shape and band",
        "Hs",
        band_height,
        "band",
        {"formula as printed": "formula"},
        1e-13,
        "round-off",
    ),
)
