"""The sea: shapes of spectra, random amplitudes and directions, focused crests."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from owt_model.config import CaseConfig, SeaStateConfig, parse_case
from owt_model.contracts import SeaState
from owt_wave_node.core import realisation, spectrum
from owt_wave_node.core.realisation import Realisation, amplitudes, realise
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state
from owt_wave_node.core.spreading import angle_of, spreading_density
from proofs.registry import Proof

Shape = Callable[..., np.ndarray]
HS, TP, G = 6.0, 9.45, 9.81
#: Quadrature in ln f by the trapezoidal rule, which converges faster than any power for these shapes.
LOG_F = np.linspace(math.log(0.01 / TP), math.log(1e6 / TP), 40001)
F = np.exp(LOG_F)
EXPONENTS = (0.5, 1.0, 2.0, 10.0, 100.0)


def moment(density: np.ndarray, n: float) -> float:
    """Integral of f^n S(f) over the frequencies F."""
    return float(np.trapezoid(F ** (n + 1) * density, LOG_F))


def sea_of(**given: object) -> SeaStateConfig:
    sea = parse_case({"sea_state": {"hs_m": HS, "tp_s": TP} | given}).sea_state
    assert sea is not None
    return sea


# Shapes


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
        for realised in [
            realise(sea_of(spectrum=name, scale=scale, cutoff_over_peak=cutoff), duration=600.0, gravity=G)
        ]
    )


# Random amplitudes

SEEDS = range(400)


def expected() -> np.ndarray:
    """S df of the default sea, without the lowest components, that underflow."""
    variance = realise(sea_of(), duration=600.0, gravity=G).variance
    return variance[variance > 1e-12]


def squares(draw: Callable[..., np.ndarray]) -> np.ndarray:
    """a^2 / (2 S df) of 400 realisations [seed, component] of the default sea."""
    variance = expected()
    return np.array([draw(variance, kind="rayleigh", seed=s) ** 2 / (2 * variance) for s in SEEDS])


def mean_square(draw: Callable[..., np.ndarray]) -> float:
    """Distance of the mean of a^2 / (2 S df) from 1 over its standard deviation 1 / sqrt(n)."""
    found = squares(draw)
    return float(abs(found.mean() - 1) * math.sqrt(found.size))


def exponential(draw: Callable[..., np.ndarray]) -> float:
    """Kolmogorov-Smirnov distance of a^2 / (2 S df) from the exponential distribution, times sqrt(n)."""
    found = np.sort(squares(draw), axis=None)
    n = found.size
    exact = -np.expm1(-found)
    step = np.arange(n + 1) / n
    return float(max(np.abs(step[1:] - exact).max(), np.abs(step[:-1] - exact).max()) * math.sqrt(n))


def variance_of_variance(draw: Callable[..., np.ndarray]) -> float:
    """Relative error of the variance over seeds of m0 = sum a^2 / 2, expected: sum (S df)^2."""
    s = expected()
    m0 = squares(draw) @ s
    return float(abs(m0.var() / np.sum(s**2) - 1))


def mean_amplitude(variance: np.ndarray, **how: object) -> np.ndarray:
    """Eq. 2.23 with the mean mu = sqrt(2 S df), where it is the root mean square that equals it."""
    return amplitudes(variance, **how) * math.sqrt(4 / math.pi)  # type: ignore[arg-type]


def rescaled(variance: np.ndarray, **how: object) -> np.ndarray:
    """Rayleigh amplitudes scaled back to the variance of the spectrum."""
    a = amplitudes(variance, **how)  # type: ignore[arg-type]
    return np.asarray(a * math.sqrt(2 * variance.sum() / np.sum(a**2)))


def deterministic(variance: np.ndarray, **_: object) -> np.ndarray:
    return amplitudes(variance, kind="deterministic", seed=0)


def uniform(variance: np.ndarray, *, seed: int, **_: object) -> np.ndarray:
    """Amplitudes of the right mean square, uniform where they should be Rayleigh distributed."""
    drawn = np.random.Generator(np.random.PCG64(seed)).random(variance.size)
    return np.sqrt(2 * variance) * math.sqrt(3) * drawn


# Directions


def circle() -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights on the circle."""
    x, w = np.polynomial.legendre.leggauss(400)
    return math.pi * x, math.pi * w


def spreading_integrals(density: Callable[[np.ndarray, float], np.ndarray]) -> float:
    """Integral 1 and mean vector s / (s + 1), largest error over exponents 0.5 to 100."""
    angle, weight = circle()
    errors = []
    for s in EXPONENTS:
        d = density(angle, s)
        errors += [weight @ d - 1, weight @ (d * np.cos(angle)) - s / (s + 1), weight @ (d * np.sin(angle))]
    return float(np.abs(errors).max())


def quantiles(inverse: Callable[[np.ndarray, float], np.ndarray]) -> float:
    """Largest error of the density integrated from -pi to the angle of a probability."""
    x, w = np.polynomial.legendre.leggauss(400)
    worst = 0.0
    probability = np.array([0.01, 0.2, 0.5, 0.7, 0.999])
    for s in EXPONENTS:
        for p, end in zip(probability, inverse(probability, s), strict=True):
            half = (end + math.pi) / 2
            worst = max(worst, abs(half * (w @ spreading_density(half * (x + 1) - math.pi, s)) - p))
    return float(worst)


def mean_vector(draw: Callable[[int, int, float], np.ndarray]) -> float:
    """Mean cosine and sine of 20,000 directions, their distance from s/(s + 1) and 0 in standard errors."""
    n, worst = 20_000, 0.0
    for s in (1.0, 5.0, 25.0):
        first, second = s / (s + 1), s * (s - 1) / ((s + 1) * (s + 2))
        angle = draw(n, 7, s)
        error = [np.cos(angle).mean() - first, np.sin(angle).mean()]
        spread = [math.sqrt(((1 + second) / 2 - first**2) / n), math.sqrt((1 - second) / 2 / n)]
        worst = max(worst, float(np.max(np.abs(error) / spread)))
    return worst


# Focused crests


def focus_case(**given: object) -> CaseConfig:
    sea = {"hs_m": HS, "tp_s": TP, "direction_deg": 30.0} | given
    return parse_case({"sea_state": sea, "wave": {"order": 1}, "time": {"dt_s": 0.25, "n": 2400}})


def at(sea: SeaState, time: np.ndarray, place: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Elevation in m and its rate in m/s, as sums of components."""
    b = np.deg2rad(sea.component_direction_deg)
    x = place[0] * np.cos(b) + place[1] * np.sin(b)
    psi = np.outer(time, sea.omega_rad_s) - (sea.wavenumber_rad_m * x + sea.phase_rad)
    return np.cos(psi) @ sea.amplitude_m, -np.sin(psi) @ (sea.omega_rad_s * sea.amplitude_m)


def crest(build: Callable[[CaseConfig], SeaState]) -> float:
    """Error of the crest, and of its slope per omega_p, over the crest: alone, embedded, short-crested."""
    worst = 0.0
    for more in ({"background": False}, {}, {"spreading": 5.0}, {"amplitudes": "rayleigh", "seed": 4}):
        focus: dict[str, object] = {"crest_m": 7.0, "time_s": 210.3, "place_m": [35.0, -60.0]}
        if "background" in more:
            focus |= more
            more = {}
        sea = build(focus_case(focus=focus, **more))
        elevation, rate = at(sea, np.array([210.3]), (35.0, -60.0))
        worst = max(worst, abs(elevation[0] / 7.0 - 1), abs(rate[0]) * TP / (2 * math.pi * 7.0))
    return float(worst)


def random_of(case: CaseConfig) -> tuple[Realisation, SeaState]:
    """The sea of a focus case without its focus."""
    sea = case.sea_state
    assert sea is not None
    plain = case.model_copy(update={"sea_state": sea.model_copy(update={"focus": None})})
    return realise(sea, duration=case.time.duration_s, gravity=G), build_sea_state(plain)


def scaled_group(case: CaseConfig, weight: Callable[[np.ndarray], np.ndarray]) -> SeaState:
    """A group of the right height at the right time and place, embedded, its slope left alone."""
    assert case.sea_state is not None
    focus = case.sea_state.focus
    assert focus is not None
    realised, sea = random_of(case)
    b = np.deg2rad(sea.component_direction_deg)
    x = focus.place_m[0] * np.cos(b) + focus.place_m[1] * np.sin(b)
    gained = np.exp(1j * (sea.omega_rad_s * focus.time_s - sea.wavenumber_rad_m * x))
    there = sea.amplitude_m * np.exp(-1j * sea.phase_rad) * gained * focus.background
    group = weight(realised.variance)
    there = there + (focus.crest_m - there.real.sum()) * group / group.sum()
    amplitude = there / gained
    return replace(sea, amplitude_m=np.abs(amplitude), phase_rad=-np.angle(amplitude))


def at_origin(case: CaseConfig) -> SeaState:
    """The crest at the origin instead of at its place."""
    assert case.sea_state is not None
    assert case.sea_state.focus is not None
    focus = case.sea_state.focus.model_copy(update={"place_m": (0.0, 0.0)})
    return build_sea_state(
        case.model_copy(update={"sea_state": case.sea_state.model_copy(update={"focus": focus})})
    )


def newwave_shape(build: Callable[[CaseConfig], SeaState]) -> float:
    """Largest error over the crest of the group alone, by the wave field, against the autocorrelation."""
    case = focus_case(focus={"crest_m": 5.0, "time_s": 300.0, "place_m": [20.0, 10.0], "background": False})
    sea = build(case)
    first, _ = make_field(case, sea).elevation(Frame(sea.direction_deg).place(np.array([[20.0, 10.0]])))
    f, s = spectrum.spectral_density(case)
    lag = 0.25 * np.arange(2400) - 300.0
    exact = np.cos(2 * math.pi * np.outer(lag, f)) @ s / s.sum()
    return float(np.abs(first[0] / 5.0 - exact).max())


def conditional_variance(build: Callable[[CaseConfig], SeaState]) -> float:
    """Variance about the crest over m0, 500 seeds, less 1 - r^2 - r'^2/-r''(0), over its error sqrt(2/n)."""
    n = 500
    lag = np.arange(-12.0, 12.1, 0.5)
    records = []
    for seed in range(n):
        focus = {"crest_m": 6.0, "time_s": 100.0}
        case = parse_case(
            {
                "sea_state": {"hs_m": HS, "tp_s": TP, "seed": seed, "amplitudes": "rayleigh", "focus": focus},
                "time": {"dt_s": 1.0, "n": 200},
            }
        )
        records.append(at(build(case), 100.0 + lag, (0.0, 0.0))[0])
    f, s = spectrum.spectral_density(case)
    omega, share = 2 * math.pi * f, s / s.sum()
    r = np.cos(np.outer(lag, omega)) @ share
    slope = np.sin(np.outer(lag, omega)) @ (omega * share) / math.sqrt(omega**2 @ share)
    found = np.array(records).var(axis=0) / (HS**2 / 16)
    return float(np.abs(found - (1 - r**2 - slope**2)).max() / math.sqrt(2 / n))


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
    Proof(
        "rayleigh-mean-square",
        "E[a^2] = 2 S df of Rayleigh amplitudes, 400 seeds",
        "1, in standard errors 1/sqrt(n)",
        mean_square,
        amplitudes,
        {"mean of a is sqrt(2 S df)": mean_amplitude},
        4.0,
        "four standard errors: 1 in 16,000",
    ),
    Proof(
        "rayleigh-distribution",
        "a^2 of Rayleigh amplitudes is exponential, 400 seeds",
        "Kolmogorov-Smirnov distance times sqrt(n)",
        exponential,
        amplitudes,
        {"deterministic": deterministic, "uniform": uniform, "mean of a is sqrt(2 S df)": mean_amplitude},
        1.95,
        "exceeded by 1 in 1000 samples",
    ),
    Proof(
        "rayleigh-variance",
        "m0 of Rayleigh realisations fluctuates as that of a finite record",
        "variance sum (S df)^2 over 400 seeds",
        variance_of_variance,
        amplitudes,
        {"scaled back to Hs": rescaled, "deterministic": deterministic},
        0.31,
        "four standard errors sqrt((2 + excess kurtosis 0.4)/400)",
    ),
    Proof(
        "spreading-density",
        "cos^2s(angle/2) integrates to 1 and has the mean vector s/(s + 1)",
        "Gauss quadrature, s from 0.5 to 100",
        spreading_integrals,
        spreading_density,
        {
            "full angle": lambda a, s: np.where(
                np.abs(a) < math.pi / 2, spreading_density(2 * a, s) * 2, 0.0
            ),
            "Gamma(s + 1/2)^2 / Gamma(2 s + 1)": lambda a, s: spreading_density(a, s) * math.sqrt(s),
        },
        1e-10,
        "quadrature",
    ),
    Proof(
        "spreading-quantiles",
        "angles of given probability",
        "integral of the density",
        quantiles,
        angle_of,
        {
            "half the angle": lambda p, s: angle_of(p, s) / 2,
            "s for s + 1/2": lambda p, s: angle_of(p, s - 0.5 + 1e-9),
        },
        1e-10,
        "quadrature",
    ),
    Proof(
        "directions-drawn",
        "directions drawn have the mean vector of the distribution",
        "s/(s + 1) and 0 in standard errors of 20,000",
        mean_vector,
        lambda n, seed, s: realisation.directions(n, seed, exponent=s),
        {
            "exponent 2 s": lambda n, seed, s: realisation.directions(n, seed, exponent=2 * s),
            "one side": lambda n, seed, s: np.abs(realisation.directions(n, seed, exponent=s)),
        },
        4.0,
        "four standard errors: 1 in 16,000",
    ),
    Proof(
        "focus-crest",
        "crest of given height with zero slope at the time and place of the focus",
        "sum of the components there",
        crest,
        build_sea_state,
        {
            "slope left alone": lambda case: scaled_group(case, lambda s: s),
            "place ignored": at_origin,
            "no focus": lambda case: random_of(case)[1],
        },
        1e-12,
        "round-off",
    ),
    Proof(
        "newwave-shape",
        "NewWave alone is the autocorrelation of the sea, through the wave field",
        "sum S df cos(omega tau) / m0",
        newwave_shape,
        build_sea_state,
        {"weights sqrt(S)": lambda case: scaled_group(case, np.sqrt), "place ignored": at_origin},
        1e-11,
        "round-off of the transform",
    ),
    Proof(
        "focus-conditional-variance",
        "seas with an embedded crest scatter about it as a Gaussian process with that crest does, 500 seeds",
        "1 - r^2 - r'^2/-r''(0), in standard errors sqrt(2/n)",
        conditional_variance,
        build_sea_state,
        {
            "slope left alone": lambda case: scaled_group(case, lambda s: s),
            "no focus": lambda case: random_of(case)[1],
        },
        4.5,
        "49 lags, correlated: four and a half standard errors",
    ),
)
