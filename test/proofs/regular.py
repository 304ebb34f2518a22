"""Regular waves, the current and Grue's profile: published values, limits, boundary conditions."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from owt_model.config import parse_case
from owt_wave_node.core.current import current_velocity
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.grue import GrueCrest, grue_crest
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import build_sea_state
from owt_wave_node.core.steady import steady_wave
from proofs.cases import DATA, relative
from proofs.flow import chebyshev
from proofs.registry import Proof

G, DEPTH = 9.81, 50.0
#: Samples of one period: above twice the highest product of harmonics that a check forms.
SAMPLES = 128
STEEP = {"height_m": 17.0, "period_s": 14.0}
MODERATE = {"height_m": 8.0, "period_s": 10.0}


@dataclass(frozen=True)
class Motion:
    """Elevation and kinematics [..., time] over one period, and the speed of the wave."""

    eta: np.ndarray
    u: np.ndarray
    w: np.ndarray
    du: np.ndarray
    dw: np.ndarray
    celerity: float
    step: float

    def rate(self, signal: np.ndarray) -> np.ndarray:
        """Time derivative of a signal by its Fourier series."""
        harmonic = np.fft.rfftfreq(SAMPLES, self.step) * 2.0 * np.pi
        return np.fft.irfft(1j * harmonic * np.fft.rfft(signal), SAMPLES)


def field_of(wave: dict[str, Any], theory: str, **more: Any) -> tuple[Any, float, float]:
    """Field of a regular wave over one period, its speed and the time step."""
    given = steady_wave(
        theory,
        height=wave["height_m"],
        period=wave.get("period_s"),
        length=wave.get("length_m"),
        order=wave.get("order"),
        depth=DEPTH,
        gravity=G,
    )
    step = given.period / SAMPLES
    case = parse_case(
        {
            "sea_state": None,
            "regular": {"theory": theory, "phase_rad": 0.4} | wave,
            "time": {"dt_s": step, "n": SAMPLES},
            "wave": {"order": 1, "stretching": "none"},
        }
        | more
    )
    return make_field(case, build_sea_state(case)), given.length / given.period, step


def at_levels(z: np.ndarray, wave: dict[str, Any], theory: str = "stream") -> Motion:
    """Motion at levels in m, x = 11 m."""
    field, celerity, step = field_of(wave, theory)
    place = np.column_stack([np.full_like(z, 11.0), np.zeros_like(z), z])
    return Motion(field.elevation(place)[0], *field.first(place).transpose(1, 0, 2), celerity, step)


def at_surface(wave: dict[str, Any], theory: str = "stream") -> Motion:
    """Motion at the instantaneous surface."""
    eta = at_levels(np.zeros(1), wave, theory).eta[0]
    every = at_levels(eta, wave, theory)
    return Motion(eta, *(np.diag(part) for part in (every.u, every.w, every.du, every.dw)),
                  every.celerity, every.step)  # fmt: skip


def published(solve: dict[str, Any]) -> float:
    """Largest relative error of length, crest and velocity at the crest."""
    waves = json.loads((DATA / "regular" / "stream_function.json").read_text(encoding="utf-8"))["waves"]
    worst = 0.0
    for height, period, *expected in waves:
        given = {"height_m": height, "period_s": period} | solve
        theory = given.pop("theory")
        motion = at_surface(given, theory)
        # The highest sample is not the crest: a Fourier series of the samples is, at the phase 0.4.
        top, speed = (
            fourier_at(signal, 11.0 / motion.celerity, motion, period) for signal in (motion.eta, motion.u)
        )
        found = [motion.celerity * period, top, speed]
        worst = max(worst, *(abs(a / b - 1.0) for a, b in zip(found, expected, strict=True)))
    return worst


def fourier_at(signal: np.ndarray, delay: float, motion: Motion, period: float) -> float:
    """Value of a periodic signal when the crest passes x = 11 m."""
    harmonic = np.fft.rfftfreq(SAMPLES, 1.0 / SAMPLES)
    coefficient = np.fft.rfft(signal) / SAMPLES
    coefficient[1:] *= 2.0
    turn = 2.0 * np.pi * delay / period + 0.4
    return float((coefficient * np.exp(1j * harmonic * turn)).sum().real)


def approach(one: Callable[[float], Motion], other: Callable[[float], Motion]) -> float:
    """Rate in the height at which two waves of one length approach each other, in eta, u and w."""
    heights, gaps = np.array([1.0, 0.5]), []
    for height in heights:
        a, b = one(float(height)), other(float(height))
        # Amplitudes, not samples: periods differ, and samples are those of a period.
        gaps.append(
            [
                np.abs(np.fft.rfft(p) - np.fft.rfft(q)).max()
                for p, q in ((a.eta, b.eta), (a.u, b.u), (a.w, b.w))
            ]
        )
    return np.log2(np.divide(*gaps))


LEVELS = np.array([-20.0, -6.0])


def wave_of(theory: str, order: int | None = None, times: float = 1.0) -> Callable[[float], Motion]:
    """A wave of 150 m of any height, which is multiplied."""
    return lambda height: at_levels(
        LEVELS, {"height_m": times * height, "length_m": 150.0, "order": order}, theory
    )


def airy_limit(times: float) -> float:
    """Largest deviation from the rate 2 of stream function and Stokes waves towards Airy waves."""
    airy = wave_of("airy", times=times)
    return max(float(np.abs(approach(wave_of(t), airy) - 2.0).max()) for t in ("stream", "stokes"))


def stokes_orders(less: int) -> float:
    """Largest deviation from the rate n + 1 of the surface of Stokes waves towards a stream function."""
    stream = wave_of("stream")
    return max(abs(float(approach(wave_of("stokes", n - less), stream)[0]) - n - 1.0) for n in (2, 3, 4, 5))


def second_coefficient(closed: Callable[[float, float], float]) -> float:
    """Largest relative error of the second harmonic over the first one squared, against a closed form."""
    worst = 0.0
    for period, depth in ((5.0, 50.0), (10.0, 50.0), (15.0, 50.0), (10.0, 20.0)):
        k = float(wavenumber(np.array([2.0 * np.pi / period]), water_depth=depth, gravity=G)[0])
        for theory, order, height in (("stokes", 2, 1.0), ("stokes", 5, 0.01), ("stream", 20, 0.01)):
            wave = steady_wave(
                theory,
                height=height,
                period=None,
                length=2.0 * np.pi / k,
                order=order,
                depth=depth,
                gravity=G,
            )
            found = wave.elevation[1] / wave.elevation[0] ** 2
            worst = max(worst, abs(found / closed(k, depth) - 1.0))
    return worst


def stokes_second(k: float, d: float) -> float:
    """Coefficient of THEORY's closed form."""
    return k * math.cosh(k * d) * (2.0 + math.cosh(2.0 * k * d)) / (4.0 * math.sinh(k * d) ** 3)


Change = Callable[[Motion], Motion]


def potential_flow(change: Change) -> float:
    """Divergence and vorticity from the bed to the trough, over the largest gradient; and w at the bed."""
    z, by_z = chebyshev(-DEPTH, -6.0, 24)
    motion = change(at_levels(z, STEEP))
    u_x, w_x = -motion.du / motion.celerity, -motion.dw / motion.celerity  # of a wave that does not change
    u_z, w_z = by_z @ motion.u, by_z @ motion.w
    bed = np.abs(motion.w[z == z.min()]).max() / np.abs(motion.w).max()
    return max(float(np.abs(part).max() / np.abs(w_z).max()) for part in (u_x + w_z, u_z - w_x)) + float(bed)


def kinematic(motion: Motion) -> float:
    """Residual of eta_t + u eta_x = w at the surface, over the largest w."""
    rate = motion.rate(motion.eta)
    return float(np.abs(rate * (1.0 - motion.u / motion.celerity) - motion.w).max() / np.abs(motion.w).max())


def dynamic(motion: Motion) -> float:
    """Range of ((u - c)^2 + w^2) / 2 + g eta over the surface, over g H."""
    head = 0.5 * ((motion.u - motion.celerity) ** 2 + motion.w**2) + G * motion.eta
    return float(np.ptp(head) / (G * np.ptp(motion.eta)))


def surface(variant: tuple[str, int | None]) -> float:
    """The larger residual of the two boundary conditions at the surface, for a theory and its order."""
    theory, order = variant
    motion = at_surface(MODERATE | {"order": order}, theory)
    return max(kinematic(motion), dynamic(motion))


def accelerations(change: Change) -> float:
    """Largest difference of the accelerations and the time derivatives of the velocities, relative."""
    worst = 0.0
    for theory in ("airy", "stokes", "stream"):
        motion = change(at_levels(np.array([-30.0, -5.0, 3.0, 20.0]), STEEP, theory))
        for rate, signal in ((motion.du, motion.u), (motion.dw, motion.w)):
            worst = max(worst, relative(rate, motion.rate(signal)))
    return worst


def convective(motion: Motion) -> Motion:
    """Acceleration of a particle: (1 - u/c) times the local one, and w times the derivative along z."""
    return replace(
        motion, du=motion.du * (1.0 - motion.u / motion.celerity) - motion.w * motion.dw / motion.celerity
    )


def mean_velocity(change: Callable[[Motion], np.ndarray]) -> float:
    """Largest mean over a period of the horizontal velocity below the trough, over its largest value."""
    motion = at_levels(np.array([-45.0, -20.0, -7.0]), STEEP)
    u = change(motion)
    return float(np.abs(u.mean(axis=1)).max() / np.abs(u).max())


def without_transport(motion: Motion) -> np.ndarray:
    """Velocity less the mean transport over the depth, Stokes' second definition of the speed."""
    top = at_surface(STEEP)
    # To second order the transport is that between trough and crest, mean(eta u).
    return motion.u - float((top.eta * top.u).mean()) / DEPTH


def currents(wrong: str) -> float:
    """Largest difference of the current's velocity and its formulas, in m/s."""
    z = np.linspace(-DEPTH, 8.0, 30)
    below, b = np.minimum(z, 0.0), np.deg2rad(240.0)
    if wrong == "comes from":
        b += np.pi
    if wrong == "continues above still water":
        below = z
    formulas: list[tuple[dict[str, Any], np.ndarray]] = [
        ({"profile": "uniform", "speed_m_s": 0.7}, np.full(z.size, 0.7)),
        ({"profile": "power", "speed_m_s": 1.3, "exponent": 0.2}, 1.3 * (1.0 + below / DEPTH) ** 0.2),
        ({"profile": "table", "table": [[0.0, 2.0], [-50.0, 0.5]]}, 2.0 + below * 0.03),
    ]
    worst = 0.0
    for current, speed in formulas:
        got = current_velocity(parse_case({"current": current | {"direction_deg": 240.0}}), z)
        worst = max(worst, float(np.abs(got - np.outer(speed, [np.cos(b), np.sin(b)])).max()))
    return worst


def grue(solve: Callable[[float, float], GrueCrest]) -> float:
    """Largest residual of both equations and of the velocity at the crest."""
    worst = 0.0
    for height, period in ((1.0, 6.0), (5.0, 7.0), (9.0, 9.0), (12.0, 9.5)):
        found, omega = solve(height, period), 2.0 * math.pi / period
        e, k = found.slope, found.wavenumber
        velocity = e * math.sqrt(G / k) * math.exp(k * height)
        worst = max(
            worst,
            abs(omega**2 / (G * k) - 1.0 - e**2),
            abs(k * height - e - 0.5 * e**2 - 0.5 * e**3),
            abs(float(found.velocity(np.array([height]))[0]) / velocity - 1.0),
        )
    return worst


def grue_linear(height: float, period: float) -> GrueCrest:
    """Linear dispersion, and a slope k eta."""
    k = (2.0 * math.pi / period) ** 2 / G
    return GrueCrest(height, k * height, k, G)


PROOFS = (
    Proof(
        key="stream-function-published",
        claim="length, crest and crest velocity of stream function waves",
        against="published values of four waves of 2.5 to 17 m",
        error=published,
        right={"theory": "stream"},
        wrong={
            "Stokes of fifth order": {"theory": "stokes"},
            "third order": {"theory": "stream", "order": 3},
            "Airy": {"theory": "airy"},
        },
        allowed=1e-4,
        reason="digits of the published values, 1.887 m/s the shortest",
    ),
    Proof(
        key="regular-airy-limit",
        claim="stream function and Stokes waves approach Airy waves with the square of the height",
        against="rate 2 of eta, u and w, H 1 and 0.5 m, length 150 m",
        error=airy_limit,
        right=1.0,
        wrong={"Airy wave of twice the height": 2.0},
        allowed=0.15,
        reason="band of fitted rates",
    ),
    Proof(
        key="stokes-orders",
        claim="the surface of Stokes waves of order n approaches that of a stream function with H^(n+1)",
        against="rates 3 to 6 of orders 2 to 5, H 1 and 0.5 m, length 150 m",
        error=stokes_orders,
        right=0,
        wrong={"an order less": 1},
        allowed=0.15,
        reason="band of fitted rates",
    ),
    Proof(
        key="regular-second-harmonic",
        claim="second harmonic of Stokes and stream function waves",
        against="k cosh kd (2 + cosh 2kd) / (4 sinh^3 kd), four waves",
        error=second_coefficient,
        right=stokes_second,
        wrong={
            "deep water": lambda k, d: 0.5 * k,
            "1 + cosh 2kd": lambda k, d: (
                stokes_second(k, d) * (1.0 + math.cosh(2.0 * k * d)) / (2.0 + math.cosh(2.0 * k * d))
            ),
        },
        allowed=5e-6,
        reason="fourth order of waves of 0.01 m, and round-off of their second harmonic",
    ),
    Proof(
        key="stream-function-potential-flow",
        claim="a stream function wave is divergence-free, irrotational and tight at the bed",
        against="spectral derivatives, H 17 m, T 14 s",
        error=potential_flow,
        right=lambda motion: motion,
        wrong={
            "w falls to the other side": lambda motion: replace(motion, w=-motion.w, dw=-motion.dw),
            "cosh instead of sinh in w": lambda motion: replace(motion, w=motion.du / motion.celerity),
        },
        allowed=1e-10,
        reason="round-off of a Chebyshev derivative of order 24",
    ),
    Proof(
        key="stream-function-surface",
        claim="no flow through the surface of a stream function wave, and no pressure on it",
        against="kinematic and Bernoulli condition at the moving surface, H 8 m, T 10 s",
        error=surface,
        right=("stream", None),
        wrong={
            "ten harmonics": ("stream", 10),
            "Stokes of fifth order": ("stokes", None),
            "Airy, extrapolated": ("airy", None),
        },
        allowed=1e-11,
        reason="round-off: 20 harmonics leave nothing between the points where they solve the conditions",
    ),
    Proof(
        key="regular-accelerations",
        claim="accelerations of regular waves are the time derivatives of their velocities",
        against="derivative of the Fourier series in time, below trough to above crest",
        error=accelerations,
        right=lambda motion: motion,
        wrong={"with the convective term": convective},
        allowed=1e-11,
        reason="round-off of the highest harmonics",
    ),
    Proof(
        key="regular-mean-velocity",
        claim="a regular wave carries no mean velocity below its trough: the current is what is given",
        against="mean over one period at three levels",
        error=mean_velocity,
        right=lambda motion: motion.u,
        wrong={"no mean transport instead": without_transport},
        allowed=1e-13,
        reason="round-off of a mean",
    ),
    Proof(
        key="current-profiles",
        claim="uniform, power-law and tabulated current, constant above still water",
        against="the formulas, 30 levels",
        error=currents,
        right="",
        wrong={name: name for name in ("comes from", "continues above still water")},
        allowed=1e-14,
        reason="round-off of m/s",
    ),
    Proof(
        key="grue",
        claim="Grue's local wave number and slope solve eq. 2.20, the crest velocity is eq. 2.21",
        against="the equations, four crests",
        error=grue,
        right=lambda height, period: grue_crest(height, period, water_depth=200.0, gravity=G),
        wrong={"linear wave": grue_linear},
        allowed=1e-14,
        reason="round-off",
    ),
)
