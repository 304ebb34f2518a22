"""Second order against closed forms, published values and the reference seas."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import build_sea_state, waves
from owt_wave_node.core.transfer import transfer
from proofs import cases, flow
from proofs.literal import Literal
from proofs.registry import Proof

G = 9.81
#: B+ and B- of two components [m, n], from their frequencies, wave numbers and the depth.
Pair = Callable[[np.ndarray, np.ndarray, float], tuple[np.ndarray, np.ndarray]]
#: eta2 / a^2 of one component in 1/m by period in s and depth in m: Stokes' second order, eight decimals.
STOKES = {
    (5.0, 50.0): 0.08048615,
    (10.0, 50.0): 0.02351352,
    (15.0, 50.0): 0.02510208,
    (10.0, 20.0): 0.06633190,
}


def code(omega: np.ndarray, k: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    t = transfer(omega, k, water_depth=depth, gravity=G)
    return t.b_plus, t.b_minus


def printed(omega: np.ndarray, k: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Eq. 4.19 as the thesis prints it: R_m R_n with the other sign in B+ and in B-."""
    plus, minus = code(omega, k, depth)
    s = omega / math.sqrt(G)
    return plus - 0.5 * np.outer(s, s), minus + 0.5 * np.outer(s, s)


def unlike_potentials(omega: np.ndarray, k: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """D+ and D- left out."""
    t = transfer(omega, k, water_depth=depth, gravity=G)
    s = np.outer(omega, omega) / G
    return t.b_plus - 0.25 * t.d_plus / s, t.b_minus - 0.25 * t.d_minus / s


def numbers(periods: list[float], depth: float) -> tuple[np.ndarray, np.ndarray]:
    omega = 2.0 * math.pi / np.array(periods)
    return omega, wavenumber(omega, water_depth=depth, gravity=G)


def stokes(pair: Pair) -> float:
    """eta2 / a^2 = k cosh kd (2 + cosh 2kd) / (4 sinh^3 kd), largest relative error."""
    worst = 0.0
    for period, depth in [*STOKES, (12.0, 8.0), (3.0, 200.0), (9.45, 50.0)]:
        omega, k = numbers([period], depth)
        kd = float(k[0]) * depth
        exact = k[0] * math.cosh(kd) * (2.0 + math.cosh(2.0 * kd)) / (4.0 * math.sinh(kd) ** 3)
        worst = max(worst, abs(float(pair(omega, k, depth)[0][0, 0]) / exact - 1.0))
    return worst


def stokes_values(pair: Pair) -> float:
    return max(
        abs(float(pair(*numbers([period], depth), depth)[0][0, 0]) - value)
        for (period, depth), value in STOKES.items()
    )


def two_values(pair: Pair) -> float:
    """T = 10 and 9 s at 50 m."""
    plus, minus = pair(*numbers([10.0, 9.0], 50.0), 50.0)
    expected = np.array([[0.02504470] * 2, [-0.00719192] * 2])
    return float(np.abs(np.array([plus[[0, 1], [1, 0]], minus[[0, 1], [1, 0]]]) - expected).max())


def deep(variant: tuple[Pair, float]) -> float:
    """B+ = (k1 + k2) / 4 and B- = -|k1 - k2| / 4 in deep water."""
    pair, depth = variant
    omega, k = numbers([10.0, 9.0], depth)
    plus, minus = pair(omega, k, depth)
    sums, differences = 0.25 * (k[0] + k[1]), -0.25 * abs(k[0] - k[1])
    return max(abs(float(plus[0, 1] / sums) - 1.0), abs(float(minus[0, 1] / differences) - 1.0))


def bracket(above: Callable[[float, float, float], float]) -> float:
    """k^2 - R^2 = k^2 / cosh^2 kd at kd = 12, where the subtraction has lost nine digits."""
    depth = 50.0
    omega, k = numbers([2.0 * math.pi / math.sqrt(G * 12.0 / depth)], depth)
    exact = k[0] ** 2 / math.cosh(k[0] * depth) ** 2
    return abs(above(float(omega[0]), float(k[0]), depth) / exact - 1.0)


def bracket_of_the_code(omega: float, k: float, depth: float) -> float:
    """D+ of one component is 12 R (k^2 - R^2) / (4 R - 2 k tanh 2kd)."""
    t = transfer(np.array([omega]), np.array([k]), water_depth=depth, gravity=G)
    r = omega**2 / G
    return float(t.d_plus[0, 0]) * (4.0 * r - 2.0 * k * math.tanh(2.0 * k * depth)) / (12.0 * r)


def stokes_in_time(multiple: float) -> float:
    """u2 = 3/4 a^2 omega k cosh 2k(z+d) / sinh^4 kd cos 2 psi, w2, and eta2 with its set-down."""
    a, omega, depth, z, x = 1.3, 2.0 * math.pi / 10.0, 20.0, -4.0, 3.0
    k = float(wavenumber(np.array([omega]), water_depth=depth, gravity=G)[0])
    case = cases.listed(
        omega, a, 0.4, water_depth_m=depth, time={"dt_s": 0.1, "n": 100}, points_m=[[x, 0.0, z]]
    )
    got = wave_kinematics(case)
    psi, kd, level = omega * got.t - k * x - 0.4, k * depth, multiple * k * (z + depth)
    b = k * math.cosh(kd) * (2.0 + math.cosh(2.0 * kd)) / (4.0 * math.sinh(kd) ** 3)
    eta2 = a**2 * (b * np.cos(2.0 * psi) - k / (2.0 * math.sinh(2.0 * kd)))
    scale = 0.75 * a**2 * omega * k / math.sinh(kd) ** 4
    return max(
        cases.relative(got.eta2[:, 0], eta2),
        cases.relative(got.velocity2[:, 0, 0], scale * math.cosh(level) * np.cos(2.0 * psi)),
        cases.relative(got.velocity2[:, 0, 2], -scale * math.sinh(level) * np.sin(2.0 * psi)),
    )


def set_down(change: Callable[[np.ndarray], np.ndarray]) -> float:
    """Mean of eta2 over its whole period, against the sum and against the reference."""
    worst = 0.0
    for name in "AC":
        d, sea = cases.reference(name), waves(build_sea_state(cases.recorded(name)))
        mean = change(component_field(sea).elevation(flow.at((0.0, 0.0, 0.0)))[1]).mean()
        exact = -np.sum(d["a"] ** 2 * d["k"] / (2.0 * np.sinh(2.0 * d["k"] * 50.0)))
        worst = max(worst, abs(mean / exact - 1.0), abs(mean / float(d["mean_setdown"]) - 1.0))
    return worst


def rows(d: dict[str, np.ndarray], key: str) -> np.ndarray:
    return np.rint(d[key] / 0.1).astype(int)


@cache
def reference_terms(name: str) -> np.ndarray:
    """First, sum and difference terms at the points of a reference sea, [point, u w du dw, term, time]."""
    d, sea = cases.reference(name), waves(build_sea_state(cases.recorded(name)))
    place = np.column_stack([d["points"][:, 0], 0.0 * d["points"][:, 0], d["points"][:, 1]])
    plus, minus = flow.parts(component_field, sea, lambda field: field.second(place))
    first = component_field(sea).first(place)
    return np.stack([first, plus, minus], axis=2)[..., rows(d, "t")]


@cache
def reference_elevations(name: str) -> np.ndarray:
    """First, sum and difference terms of the elevation at x = 0, [term, time]."""
    sea = waves(build_sea_state(cases.recorded(name)))
    place = flow.at((0.0, 0.0, 0.0))
    plus, minus = flow.parts(component_field, sea, lambda field: field.elevation(place)[1])
    return np.stack([component_field(sea).elevation(place)[0], plus, minus])[:, 0]


def reference_kinematics(name: str) -> Callable[[Callable[[np.ndarray], np.ndarray]], float]:
    """Each term of each quantity at each point, against the largest value of that same term."""

    def error(change: Callable[[np.ndarray], np.ndarray]) -> float:
        expected = cases.reference(name)["kin"]
        scale = np.abs(expected).max(axis=-1, keepdims=True)
        return float((np.abs(change(reference_terms(name)) - expected) / scale).max())

    return error


def openfast_kinematics(change: Callable[[np.ndarray], np.ndarray]) -> float:
    """As above; the sum terms of sea C are left out, of which single precision leaves three digits."""
    a, c = (cases.openfast()[f"kin_{name}"].astype(float) for name in "AC")
    got_a, got_c = (change(reference_terms(name)) for name in "AC")
    pairs = [(got_a, a), (got_c[:, :, ::2], c[:, :, ::2])]
    return max(float((np.abs(x - y).max(axis=-1) / np.abs(y).max(axis=-1)).max()) for x, y in pairs)


def reference_elevation(change: Callable[[np.ndarray], np.ndarray]) -> float:
    worst = 0.0
    for name in "AC":
        expected = cases.reference(name)["eta_x0"]
        got = change(reference_elevations(name))[:, rows(cases.reference(name), "t_eta")]
        worst = max(worst, *(cases.relative(a, b) for a, b in zip(got, expected, strict=True)))
    return worst


def reference_above(stretching: str) -> float:
    worst = 0.0
    for name in "AC":
        d = cases.reference(name)
        points = [[x, 0.0, z] for x, z in d["points_above"]]
        got = wave_kinematics(
            cases.recorded(name, points_m=points, wave={"order": 2, "stretching": stretching})
        )
        for q, series in enumerate(
            (got.velocity[..., 0], got.velocity[..., 2], got.acceleration[..., 0], got.acceleration[..., 2])
        ):
            worst = max(worst, cases.relative(series[rows(d, "t")].T, d["kin_above_total"][:, q]))
    return worst


def without_d_minus(terms: np.ndarray) -> np.ndarray:
    """Sum and difference terms of sea A with D- = 0, written out, at the first point and two times."""
    d, sea = cases.reference("A"), waves(build_sea_state(cases.recorded("A")))
    place, at = flow.at((float(d["points"][0, 0]), 0.0, float(d["points"][0, 1]))), rows(d, "t")[:2]
    written_out = flow.parts(
        lambda components: Literal(components, int(at[-1]) + 1, no_d_minus=True),
        sea,
        lambda field: field.second(place),
    )
    out = terms.copy()
    for term, part in enumerate(written_out, start=1):
        out[0, :, term, :2] = part[0][:, at]
    return out


def scaled(first: float, plus: float, minus: float) -> Callable[[np.ndarray], np.ndarray]:
    """The three terms times factors."""
    return lambda terms: terms * np.array([first, plus, minus])[:, None]


PROOFS = (
    Proof(
        key="stokes-second-order",
        claim="second order of one component",
        against="Stokes, closed form, 7 depths and periods",
        error=stokes,
        right=code,
        wrong={"B+ as printed (4.19)": printed, "D+ left out": unlike_potentials},
        allowed=1e-12,
        reason="round-off of the hyperbolic functions",
    ),
    Proof(
        key="stokes-values",
        claim="values of B+ of one component",
        against="Stokes to eight decimals, 4 depths and periods, in 1/m",
        error=stokes_values,
        right=code,
        wrong={"B+ as printed (4.19)": printed, "D+ left out": unlike_potentials},
        allowed=5e-9,
        reason="half a unit of the last decimal",
    ),
    Proof(
        key="two-components",
        claim="values of B+ and B- of two components",
        against="T = 10 and 9 s at 50 m to eight decimals, in 1/m",
        error=two_values,
        right=code,
        wrong={"B+ and B- as printed (4.19)": printed, "D+ and D- left out": unlike_potentials},
        allowed=5e-9,
        reason="half a unit of the last decimal",
    ),
    Proof(
        key="deep-water",
        claim="deep water limits of B+ and B-",
        against="(k1 + k2) / 4 and -abs(k1 - k2) / 4",
        error=deep,
        right=(code, 3500.0),
        wrong={"water of 50 m": (code, 50.0), "B+ and B- as printed (4.19)": (printed, 3500.0)},
        allowed=1e-12,
        reason="round-off; exp(-2 k d) is below 1e-100 for every wave number involved",
    ),
    Proof(
        key="deep-digits",
        claim="no digits lost in deep water",
        against="k^2 - R^2 = k^2 / cosh^2 kd at kd = 12",
        error=bracket,
        right=bracket_of_the_code,
        wrong={"subtraction": lambda omega, k, depth: k**2 - (omega**2 / G) ** 2},
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="stokes-in-time",
        claim="elevation and velocities of one component in time",
        against="Stokes, closed form with set-down, 20 m",
        error=stokes_in_time,
        right=2.0,
        wrong={"vertical profile of k instead of 2k": 1.0},
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="set-down",
        claim="mean set-down",
        against="-sum a^2 k / (2 sinh 2kd) and reference, A and C",
        error=set_down,
        right=lambda eta2: eta2,
        wrong={
            "left out": lambda eta2: eta2 - eta2.mean(),
            "once more (both halves of the pair)": lambda eta2: eta2 + eta2.mean(),
        },
        allowed=1e-9,
        reason="mean of a record 100 times larger: 1e-16 times 100 times the pairs",
    ),
    *(
        Proof(
            key=f"reference-kinematics-{name}",
            claim=f"velocities and accelerations of sea {name}, first, sum and difference terms",
            against=f"reference {name}, 12 points, each term over its own peak",
            error=reference_kinematics(name),
            right=lambda terms: terms,
            wrong={
                "difference pairs cancel (4.24 as printed)": scaled(1.0, 1.0, 0.0),
                "each pair once": scaled(1.0, 0.5, 0.5),
                "horizontal and vertical exchanged": lambda terms: terms[:, [1, 0, 3, 2]],
                **({"D- left out": without_d_minus} if name == "A" else {}),
            },
            allowed=1e-10,
            reason="required; both sides are double precision",
        )
        for name in "AC"
    ),
    Proof(
        key="openfast-kinematics",
        claim="velocities and accelerations as OpenFAST's SeaState gives them",
        against="OpenFAST, seas A and C, 12 points, each term over its own peak",
        error=openfast_kinematics,
        right=lambda terms: terms,
        wrong={
            "difference pairs cancel (4.24 as printed)": scaled(1.0, 1.0, 0.0),
            "each pair once": scaled(1.0, 0.5, 0.5),
        },
        allowed=5e-5,
        reason="OpenFAST computes in single precision",
    ),
    Proof(
        key="reference-elevation",
        claim="elevation, first, sum and difference terms",
        against="reference A and C, each term over its own peak",
        error=reference_elevation,
        right=lambda terms: terms,
        wrong={
            "set-down left out": lambda terms: terms - terms.mean(axis=1, keepdims=True),
            "each pair once": scaled(1.0, 0.5, 0.5),
        },
        allowed=1e-10,
        reason="required; both sides are double precision",
    ),
    Proof(
        key="reference-above",
        claim="kinematics above still water",
        against="reference A and C, Taylor expansion of the first order",
        error=reference_above,
        right="taylor",
        wrong={"constant above still water": "constant", "profile continued": "none"},
        allowed=1e-10,
        reason="required; both sides are double precision",
    ),
)
