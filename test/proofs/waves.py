"""Wave fields: potential flow, free surface to second order, rates, translations, headings, sampling."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.kinematics import Kinematics, wave_kinematics
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import Waves, build_sea_state, waves
from proofs import cases, flow
from proofs.literal import Literal
from proofs.registry import Proof

G = 9.81
TIMES = 200


@cache
def whole(name: str = "A") -> Waves:
    """All components of a reference sea."""
    return waves(build_sea_state(cases.recorded(name)))


@cache
def few(depth: float = 50.0) -> Waves:
    """Twelve waves of 2.4 to 15 s and 1 m to 0.1 m, in water of any depth."""
    multiple = np.array([4, 5, 6, 7, 8, 9, 11, 13, 15, 18, 21, 25])
    case = cases.listed(
        2.0 * np.pi / 60.0 * multiple,
        4.0 / multiple,
        np.sqrt(np.arange(12.0)) * 5.0,
        water_depth_m=depth,
        time={"dt_s": 0.2, "n": 300},
    )
    return waves(build_sea_state(case))


def literal(**switches: bool) -> flow.Make:
    """The equations as they stand, some of them as the thesis prints them."""
    return lambda components: Literal(components, TIMES, **switches)


def dispersion(solve: Callable[[np.ndarray, float], np.ndarray]) -> float:
    """Largest relative residual of g k tanh kd = omega^2."""
    omega = np.geomspace(1e-3, 60.0, 400)
    return max(
        float(np.abs(G * k * np.tanh(k * d) / omega**2 - 1.0).max())
        for d in (0.5, 20.0, 50.0, 4000.0)
        for k in [solve(omega, d)]
    )


def surface(condition: Callable[[flow.Make, Waves], float]) -> Callable[[flow.Make], float]:
    """The worst residual of a condition: few waves, three depths; for the code itself the whole seas too."""

    def error(make: flow.Make) -> float:
        seas = [few(), few(20.0), few(9.0)]
        if make is component_field:
            seas += [whole("A"), whole("C")]
        return max(condition(make, sea) for sea in seas)

    return error


class Changed:
    """A field whose second (or first) order is changed on the way out."""

    def __init__(self, inner: flow.Flow, change: Callable[[np.ndarray], np.ndarray]) -> None:
        self.inner, self.change = inner, change

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.inner.elevation(place)

    def first(self, place: np.ndarray) -> np.ndarray:
        return self.change(self.inner.first(place))

    def second(self, place: np.ndarray) -> np.ndarray:
        return self.change(self.inner.second(place))


def changed(change: Callable[[np.ndarray], np.ndarray]) -> flow.Make:
    return lambda components: Changed(component_field(components), change)


def laplace(order: int) -> Callable[[flow.Make], float]:
    """Continuity and vorticity near the surface, in the middle and at the bed."""
    spans = ((-4.0, 0.0), (-27.0, -23.0), (-50.0, -46.0))
    return lambda make: max(flow.potential_flow(make, few(), order=order, low=a, high=b) for a, b in spans)


def bed(depth: float) -> float:
    """Largest vertical velocity 50 m down over the largest horizontal one there, both orders."""
    field = component_field(few(depth))
    motions = [part(flow.at((0.0, 0.0, -50.0), (31.0, 0.0, -50.0))) for part in (field.first, field.second)]
    return max(float(np.abs(q[:, 1]).max() / np.abs(q[:, 0]).max()) for q in motions)


def convective(rate: np.ndarray, local: flow.Local, part: int) -> np.ndarray:
    """Local acceleration plus u du/dx + w du/dz of the first order; irrotational, free of divergence."""
    q, by_x = local.here[2], local.along("x")[2]
    return rate + np.stack(
        [
            q[:, 0] * by_x[:, 0] + q[:, 2] * by_x[:, 2],
            0.0 * q[:, 1],
            q[:, 0] * by_x[:, 2] - q[:, 2] * by_x[:, 0],
        ],
        axis=1,
    )


def translation(sign: float) -> float:
    """Moving on by (x, t) turns every amplitude by omega t - k x: the record begins 137 samples later."""
    sea, later = whole(), 137
    x = 11.3
    turn = np.exp(1j * (sea.omega * later * sea.dt - sign * sea.wavenumber * x))
    here = component_field(replace(sea, amplitude=sea.amplitude * turn))
    there = component_field(sea)
    worst = 0.0
    for z in (-3.0, 2.0):
        one, other = flow.at((0.0, 0.0, z)), flow.at((x, 0.0, z))
        pairs = [
            *zip(here.elevation(one), there.elevation(other), strict=True),
            (here.first(one), there.first(other)),
            (here.second(one), there.second(other)),
        ]
        worst = max([worst, *(cases.relative(a, np.roll(b, -later, axis=-1)) for a, b in pairs)])
    return worst


POINTS = np.array([[5.0, 0.0, -2.0], [-3.0, 0.0, 1.0]])


@cache
def straight() -> Kinematics:
    return wave_kinematics(cases.recorded("A", points_m=POINTS.tolist()))


def rotation(given: Callable[[float], float]) -> float:
    """Sea and points turned by b, the second point moved along the crests as well: the answer turns by b."""
    d, b, worst = cases.reference("A"), 210.0, 0.0
    c, s = np.cos(np.deg2rad(b)), np.sin(np.deg2rad(b))
    points = np.column_stack([POINTS[:, 0] * c, POINTS[:, 0] * s, POINTS[:, 2]])
    points[1] += 7.0 * np.array([-s, c, 0.0])
    case = cases.listed(d["omega"], d["a"], d["phi"], direction=given(b), points_m=points.tolist())
    got = wave_kinematics(case)
    for name in ("velocity", "acceleration", "velocity2", "acceleration2"):
        other = getattr(straight(), name)
        turned = np.stack([c * other[:, :, 0], s * other[:, :, 0], other[:, :, 2]], axis=2)
        worst = max(worst, cases.relative(getattr(got, name), turned))
    return max(worst, cases.relative(got.eta2, straight().eta2))


def single_summation(make: flow.Make) -> float:
    """All pairs of reference sea A against both sums written out, 50 times of one record."""
    sea, times = whole(), 50
    place = flow.at((3.7, 0.0, -2.0), (-8.0, 0.0, -27.0))
    field, double = make(sea), Literal(sea, times)
    worst = cases.relative(field.elevation(place)[1][:, :times], double.elevation(place)[1])
    got, expected = field.second(place)[..., :times], double.second(place)
    return max([worst, *(cases.relative(got[:, q], expected[:, q]) for q in range(4))])


def without_difference(components: Waves) -> flow.Flow:
    """Pairs (m, n) and (n, m) that cancel: only the sum terms are left."""
    field = component_field(components)
    turned = component_field(replace(components, amplitude=1j * components.amplitude))

    class SumOnly(Changed):
        def second(self, place: np.ndarray) -> np.ndarray:
            return 0.5 * (field.second(place) - turned.second(place))

    return SumOnly(field, lambda q: q)


def coarse_samples(change: Callable[[np.ndarray], np.ndarray]) -> float:
    """Samples every 2 s of waves up to 2.7 rad/s, whose pairs lie far above the Nyquist frequency."""
    place, fine = flow.at((1.0, 0.0, -3.0)), component_field(whole())
    coarse = component_field(replace(whole(), dt=2.0, n=300))
    pairs = [
        *zip(coarse.elevation(place), fine.elevation(place), strict=True),
        (coarse.first(place), fine.first(place)),
        (coarse.second(place), fine.second(place)),
    ]
    return max(cases.relative(a, change(b)[..., ::20]) for a, b in pairs)


def band_limited(series: np.ndarray) -> np.ndarray:
    """What a transform as long as the coarse record keeps: up to its Nyquist frequency."""
    spectrum = np.fft.rfft(series)
    spectrum[..., 150:] = 0.0
    return np.fft.irfft(spectrum, series.shape[-1])


def taylor(level: Callable[[float], float]) -> float:
    """Above still water q = q1(0) + z dq1/dz(0) + q2(0), the slope from continuity and zero vorticity."""
    z, sea = 2.5, whole()
    at_zero = flow.Local(component_field, sea, flow.at((4.0, 0.0, 0.0)))
    here, by_x = at_zero.here, at_zero.along("x")[2]
    slope = np.stack([by_x[:, 2], -by_x[:, 0], by_x[:, 5], -by_x[:, 3]], axis=1)
    expected = here[2][:, [0, 2, 3, 5]] + level(z) * slope + here[3][:, [0, 2, 3, 5]]
    field, place = component_field(sea), flow.at((4.0, 0.0, z))
    return cases.relative(field.first(place) + field.second(place), expected)


PROOFS = (
    Proof(
        key="dispersion",
        claim="wave numbers solve the dispersion relation",
        against="its residual, 4 depths, 1e-3 to 60 rad/s",
        error=dispersion,
        right=lambda omega, d: wavenumber(omega, water_depth=d, gravity=G),
        wrong={"deep water": lambda omega, d: omega**2 / G},
        allowed=5e-15,
        reason="a few units in the last place of tanh",
    ),
    Proof(
        key="kinematic-free-surface",
        claim="kinematic condition of the free surface to second order",
        against="sum of its terms of order a^2; 12 waves at 3 depths, seas A and C",
        error=surface(flow.kinematic),
        right=component_field,
        wrong={
            "B+ and B- as printed (4.19)": literal(printed_b=True),
            "D- left out": literal(no_d_minus=True),
            "difference terms of w left out": without_difference,
        },
        allowed=1e-13,
        reason="round-off of the sum over pairs; no finite difference is involved",
    ),
    Proof(
        key="dynamic-free-surface",
        claim="dynamic condition of the free surface to second order",
        against="its gradient along the surface; 12 waves at 3 depths, seas A and C",
        error=surface(flow.dynamic),
        right=component_field,
        wrong={
            "B+ and B- as printed (4.19)": literal(printed_b=True),
            "unsigned wave number (4.24)": literal(unsigned=True),
            "acceleration of the other sign": changed(
                lambda q: q * np.array([1.0, 1.0, -1.0, -1.0])[:, None]
            ),
        },
        allowed=1e-13,
        reason="round-off of the sum over pairs; no finite difference is involved",
    ),
    *(
        Proof(
            key=f"potential-flow-{name}",
            claim=f"continuity and no rotation, {name} order",
            against="Laplace, derivatives exact in x and spectral in z, three layers",
            error=laplace(order),
            right=component_field,
            wrong={
                "w of the other sign": changed(lambda q: q * np.array([1.0, -1.0, 1.0, -1.0])[:, None]),
                "sinh for cosh (w in place of u)": changed(lambda q: q[:, [1, 1, 3, 3]]),
            },
            allowed=2e-11,
            reason="differentiation at 21 Chebyshev points multiplies round-off by about 1e3",
        )
        for order, name in ((1, "first"), (2, "second"))
    ),
    Proof(
        key="bed",
        claim="no flow through the sea bed",
        against="zero, both orders, 12 waves on 50 m",
        error=bed,
        right=50.0,
        wrong={"profile of 51 m of water": 51.0, "profile of deep water": 500.0},
        allowed=1e-14,
        reason="exp(k z) and its image are equal at the bed to round-off",
    ),
    Proof(
        key="rates",
        claim="accelerations are the time derivatives of the velocities",
        against="derivative by the amplitudes, both orders, below and above still water",
        error=lambda change: flow.rates(component_field, whole(), change),
        right=lambda rate, local, part: rate,
        wrong={
            "convective term added": convective,
            "time of the other sign": lambda rate, local, part: -rate,
            "horizontal and vertical exchanged": lambda rate, local, part: rate[:, [2, 1, 0]],
        },
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="translation",
        claim="moving in space and time turns the phases and nothing else",
        against="the same sea with turned amplitudes, both orders, below and above still water",
        error=translation,
        right=1.0,
        wrong={"waves travelling to -x": -1.0},
        allowed=1e-12,
        reason="round-off; the derivatives of the other proofs rest on this",
    ),
    Proof(
        key="heading",
        claim="turning sea and points turns the answer",
        against="rotation of the vectors by 210 degrees, sea A",
        error=rotation,
        right=lambda b: b,
        wrong={
            "direction the waves come from": lambda b: b - 180.0,
            "measured clockwise": lambda b: -b,
        },
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="single-summation",
        claim="single summation and FFT equal the double sum",
        against="equations 4.12 to 4.24 written out over all pairs of sea A",
        error=single_summation,
        right=component_field,
        wrong={"difference pairs cancel (4.24 as printed)": without_difference},
        allowed=1e-10,
        reason="required; round-off of 64,009 pairs is 1e-14",
    ),
    Proof(
        key="coarse-samples",
        claim="coarse samples are those of the fine record",
        against="every 20th sample, sea A at 2 s and 0.1 s",
        error=coarse_samples,
        right=lambda series: series,
        wrong={"lost above the Nyquist frequency of the samples": band_limited},
        allowed=1e-12,
        reason="round-off: a transform that holds all frequencies, subsampled, is exact",
    ),
    Proof(
        key="taylor",
        claim="Taylor expansion above still water, velocities and accelerations",
        against="q1(0) + z dq1/dz(0) + q2(0) [2.19], exact slope, sea A",
        error=taylor,
        right=lambda z: z,
        wrong={"constant above still water": lambda z: 0.0, "slope of the wrong sign": lambda z: -z},
        allowed=1e-12,
        reason="round-off",
    ),
)
