"""Focused crests: NewWave alone and embedded in a random sea."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from owt_model.config import CaseConfig, parse_case
from owt_model.contracts import SeaState
from owt_wave_node.core import spectrum
from owt_wave_node.core.realisation import Realisation, realise
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state
from proofs.registry import Proof
from proofs.sea import HS, TP, G


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
