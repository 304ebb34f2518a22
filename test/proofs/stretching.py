"""Kinematics above still water, and the crests of second order."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from owt_model.config import parse_case
from owt_wave_node.core.crests import forristall_crest, forristall_shape, rayleigh_crest
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.profile import first_order_profile
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import build_sea_state, waves
from owt_wave_node.core.sea_statistics import component_statistics, record_statistics
from proofs import cases, flow
from proofs.registry import Proof

G = 9.81
#: Level of a point from its own level, the elevation and the depth.
Level = Callable[[float, np.ndarray, float], np.ndarray]


def wheeler(level: Level) -> float:
    """Velocities and accelerations of sea A at two levels, while they are wet, against direct sums."""
    d, worst, depth, x = cases.reference("A"), 0.0, 50.0, 3.0
    at = np.arange(0, 6000, 37)
    levels = (-4.0, 0.8)
    case = cases.recorded(
        "A", wave={"order": 1, "stretching": "wheeler"}, points_m=[[x, 0.0, z] for z in levels]
    )
    got = wave_kinematics(case)
    psi = got.t[at, None] * d["omega"] - d["k"] * x - d["phi"]
    eta = (d["a"] * np.cos(psi)).sum(axis=1)
    for p, z in enumerate(levels):
        above_bed = (level(z, eta, depth) + depth)[:, None] * d["k"]
        b = d["a"] * G * d["k"] / d["omega"] / np.cosh(d["k"] * depth)
        c, s, wet = b * np.cosh(above_bed), b * np.sinh(above_bed), z <= eta
        expected = {
            ("velocity", 0): c * np.cos(psi),
            ("velocity", 2): -s * np.sin(psi),
            ("acceleration", 0): -d["omega"] * c * np.sin(psi),
            ("acceleration", 2): -d["omega"] * s * np.cos(psi),
        }
        for (name, axis), terms in expected.items():
            worst = max(worst, cases.relative(getattr(got, name)[at, p, axis][wet], terms.sum(axis=1)[wet]))
    return worst


def profiles(stretching: dict[str, str]) -> float:
    """Vertical factors 2 m above still water against what each name says, two wave numbers, 20 m."""
    k, z, d = np.array([0.05, 0.3]), 2.0, 20.0
    value, slope = (np.ones(2), np.tanh(k * d)), (np.tanh(k * d), np.ones(2))
    expected = {
        "taylor": [v + k * z * s for v, s in zip(value, slope, strict=True)],
        "constant": list(value),
        "none": [part(k * (z + d)) / np.cosh(k * d) for part in (np.cosh, np.sinh)],
    }
    worst = 0.0
    for name, factors in expected.items():
        found = first_order_profile(k, np.array([z]), water_depth=d, stretching=stretching[name])
        worst = max(worst, *(cases.relative(a[0], b) for a, b in zip(found, factors, strict=True)))
    return worst


NAMES = {name: name for name in ("taylor", "constant", "none")}


@cache
def crest_record() -> tuple[np.ndarray, float, float, float]:
    """Crests of 12 h of sea of Hs 6 m in 50 m to second order, and Hs, Tm01 and its wave number."""
    crests = []
    for seed in range(12):
        case = parse_case(
            {
                "sea_state": {"hs_m": 6.0, "tp_s": 9.45, "seed": seed, "cutoff": "steepness"},
                "time": {"dt_s": 0.4, "n": 9000},
            }
        )
        sea = build_sea_state(case)
        first, second = component_field(waves(sea), "exact").elevation(flow.at((0.0, 0.0, 0.0)))
        crests.append(record_statistics(first[0] + second[0], 0.4).crest_m)
    spectrum = component_statistics(sea.omega_rad_s, sea.amplitude_m)
    k = float(wavenumber(np.array([2.0 * math.pi / spectrum.tm01_s]), water_depth=50.0, gravity=G)[0])
    return np.sort(np.concatenate(crests)), spectrum.hm0_m, spectrum.tm01_s, k


def crests(distribution: str) -> float:
    """Heights that 20, 5 and 1 % of the crests exceed."""
    found, hs, tm01, k = crest_record()
    p = np.array([0.2, 0.05, 0.01])
    at = [round(found.size * (1.0 - share)) for share in p]
    alpha, beta = forristall_shape(hs=hs, tm01=tm01, wavenumber=k, depth=50.0, gravity=G)
    expected = {
        "forristall": forristall_crest(p, hs=hs, alpha=alpha, beta=beta),
        "scale of the linear sea": forristall_crest(p, hs=hs, alpha=1.0 / math.sqrt(8.0), beta=beta),
        "rayleigh": rayleigh_crest(p, hs=hs),
    }[distribution]
    return float(np.abs(found[at] / expected - 1.0).max())


PROOFS = (
    Proof(
        key="wheeler",
        claim="Wheeler stretching of an irregular sea, velocities and accelerations",
        against="components summed directly at z' = (z - eta) / (1 + eta/d) [2.18], sea A",
        error=wheeler,
        right=lambda z, eta, d: (z - eta) / (1.0 + eta / d),
        wrong={
            "not stretched": lambda z, eta, d: np.full_like(eta, min(z, 0.0)),
            "shifted only, z - eta": lambda z, eta, d: z - eta,
            "1 - eta/d": lambda z, eta, d: (z - eta) / (1.0 - eta / d),
        },
        allowed=1e-10,
        reason="interpolation in level, refined to round-off",
    ),
    Proof(
        key="profiles-above-still-water",
        claim="taylor, constant and none do what they say above still water",
        against="value and slope at still water, value, cosh and sinh",
        error=profiles,
        right=NAMES,
        wrong={
            "constant for taylor": NAMES | {"taylor": "constant"},
            "profile continued for taylor": NAMES | {"taylor": "none"},
        },
        allowed=1e-13,
        reason="round-off",
    ),
    Proof(
        key="forristall-crests",
        claim="crests of second order have Forristall's (2000) distribution, as fitted to such simulations",
        against="heights that 20, 5 and 1 % of some 5000 crests exceed, Hs 6 m, Tp 9.45 s, 50 m",
        error=crests,
        right="forristall",
        wrong={"Rayleigh": "rayleigh", "scale of the linear sea": "scale of the linear sea"},
        allowed=0.03,
        reason="50 crests above the last height: standard error 1.5 %; the fit and the spectrum 1 to 2 %",
    ),
)
