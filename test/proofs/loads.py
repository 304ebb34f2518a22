"""Morison loads: reference jackets, closed forms, distributions between nodes, the surface, current."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from owt_model.axes import rotation
from owt_model.config import CaseConfig
from owt_model.mesh import Mesh
from owt_wave_node.core.assembly import assemble
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.hydro_mesh import HydroMesh, build_hydro_mesh
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.loads import Loads, jacket_loads
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state
from owt_wave_node.kernels import morison as kernel
from owt_wave_node.kernels.sections import sectional
from owt_wave_node.kernels.surface import surface_loads
from proofs.cases import column, listed, oc4, recorded, reference, relative
from proofs.registry import Proof

RHO, G, DIAMETER, DEPTH = 1025.0, 9.81, 1.5, 20.0
AREA, OMEGA = math.pi * DIAMETER**2 / 4.0, 2.0 * math.pi / 10.0


def simple(
    amplitude: float,
    *,
    morison: dict[str, Any],
    stretching: str = "none",
    direction: float = 0.0,
) -> CaseConfig:
    """One linear wave of 10 s, one period, in 20 m of water."""
    return listed(
        OMEGA, amplitude, 0.0, direction=direction, water_depth_m=DEPTH, time={"dt_s": 0.1, "n": 100},
        wave={"order": 1, "stretching": stretching}, morison=morison,
    )  # fmt: skip


# --- the reference jacket -----------------------------------------------------------------------------


def jacket(name: str, order: int) -> Callable[[dict[str, Any]], float]:
    """Shear, lift and overturning moment against the reference, by the peak of each."""

    def error(change: dict[str, Any]) -> float:
        fields = {"wave": {"order": order, "stretching": "taylor"}, "morison": {"discretisation_m": 0.25}}
        for key, values in change.items():
            fields[key] = fields[key] | values
        got, d = jacket_loads(recorded(name, **fields), oc4()), reference(name)
        at = np.rint(d["t_load"] / 0.1).astype(int)
        expected = d[f"load_{'linear' if order == 1 else 'second'}_dx025"]
        series = (got.force[at, 0], got.force[at, 2], got.moment[at, 1])
        return max(relative(one, other) for one, other in zip(series, expected, strict=True))

    return error


def jacket_proof(name: str, order: int, allowed: float) -> Proof:
    return Proof(
        key=f"jacket-loads-{name.lower()}-{order}",
        claim=f"Shear, lift and moment of the OC4 jacket, reference sea {name}, order {order}",
        against="reference data, 0.25 m elements, 300 s at 0.2 s",
        error=jacket(name, order),
        right={},
        wrong={
            "the other order": {"wave": {"order": 3 - order}},
            "segments on or off by their middle": {"morison": {"surface": "midpoint"}},
        },
        allowed=allowed,
        reason="the reference itself is 1e-4 (A) to 1e-3 (C) of the peak from converged",
    )


# --- closed forms -------------------------------------------------------------------------------------


def inertia_force(t: np.ndarray, a: float, *, moving: bool) -> np.ndarray:
    """Inertia force of one linear wave, its profile continued to the surface, integrated in closed form."""
    k = float(wavenumber(np.array([OMEGA]), water_depth=DEPTH, gravity=G)[0])
    top = a * np.cos(OMEGA * t) if moving else 0.0 * t
    height = np.sinh(k * (top + DEPTH)) / math.cosh(k * DEPTH)
    return np.asarray(-RHO * 2.0 * AREA * a * G * np.sin(OMEGA * t) * height)


def upright(variant: dict[str, Any]) -> float:
    """Largest error of three amplitudes and headings, over the peak."""
    worst = 0.0
    for a, heading in ((0.01, 0.0), (3.0, 0.0), (3.0, 37.0)):
        morison = {"cd": 0.0, "discretisation_m": 0.05} | variant.get("morison", {})
        got = jacket_loads(simple(a, morison=morison, direction=heading), column())
        exact = inertia_force(got.t, a, moving=variant.get("moving", True))
        along = got.force @ Frame(heading).axes[0]
        worst = max(worst, relative(along, exact), float(np.abs(got.force[:, 2]).max() / exact.max()))
    return worst


def growth(variant: bool) -> float:
    """Inertia force on D + 2 t inside the zone of growth, closed form over the two parts."""
    zone = {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -12.3, "z_top_m": -2.1}
    mesh = column(marine_growth=zone)
    morison = {"cd": 0.0, "discretisation_m": 0.05, "marine_growth": variant}
    got = jacket_loads(simple(0.01, morison=morison), mesh)
    k = float(wavenumber(np.array([OMEGA]), water_depth=DEPTH, gravity=G)[0])
    part = (math.sinh(k * (DEPTH - 2.1)) - math.sinh(k * (DEPTH - 12.3))) / math.cosh(k * DEPTH)
    extra = math.pi / 4.0 * (1.7**2 - 1.5**2)
    exact = inertia_force(got.t, 0.01, moving=True)
    exact -= RHO * 2.0 * extra * 0.01 * G * np.sin(OMEGA * got.t) * part
    return relative(got.force[:, 0], exact)


def uniform_beam(mean_as_point: bool) -> float:
    """A uniform load q on a clamped element: q L / 2 and q L^2 / 12, of opposite signs at the ends."""
    length, q = 7.0, 1000.0
    rows = np.zeros((10, 3))
    for stride in (1, 2):
        place = np.linspace(0.0, 1.0, 4 * stride + 1)
        weights = np.empty((4, stride + 1, 6))
        kernel.segment_weights(place, length, stride, mean_as_point, weights)
        wet = np.zeros((place.size, 6))
        for j in range(stride + 1):
            wet[j : j + 3 * stride + 1 : stride] += 0.5 * weights[:, j]
        kernel.add_stations(np.full((place.size, 3, 3), q), wet, rows)
    f, m = q * length / 2.0, q * length**2 / 12.0
    return relative(rows[:, 0], [f, m, f, -m, f, -m, f, m, f, f])


# --- distribution between the nodes -------------------------------------------------------------------


@cache
def inclined(distribution: str, longest: float, surface: str = "moving") -> np.ndarray:
    """Force and moment on an inclined member through the surface, inertia only (smooth)."""
    morison = {
        "cd": 0.0, "distribution": distribution, "discretisation_m": longest, "surface": surface,
    }  # fmt: skip
    mesh = column(top=(6.0, 3.0, 10.0), elements=1)
    got = jacket_loads(simple(1.0, morison=morison, stretching="taylor"), mesh)
    return np.concatenate([got.force, 0.1 * got.moment], axis=1)


def rate_error(expected: float) -> Callable[[tuple[str, str]], float]:
    """How far the fitted rate of convergence is from the expected one."""

    def error(variant: tuple[str, str]) -> float:
        truth = inclined("quadratic", 0.05)
        errors = [
            np.sqrt(np.mean((inclined(variant[0], dx, variant[1]) - truth) ** 2)) for dx in (1.0, 0.5, 0.25)
        ]
        return abs(float(np.polyfit(range(3), -np.log2(errors), 1)[0]) - expected)

    return error


def rate_proof(distribution: str, rate: float, wrong: dict[str, tuple[str, str]]) -> Proof:
    return Proof(
        key=f"{distribution}-distribution",
        claim=f"Loads of the {distribution} distribution converge at rate {rate:g} in the element's length",
        against="theory, on an inclined member through the surface, inertia only",
        error=rate_error(rate),
        right=(distribution, "moving"),
        wrong=wrong,
        allowed=0.15,
        reason="fitted from 1 to 0.25 m elements",
    )


BY_MIDDLE = {"segments on or off by their middle": ("linear", "midpoint")}


# --- equilibrium, with current and coefficients by level ----------------------------------------------

CD, CM = ((-20.0, 0.6), (-9.0, 1.1), (-4.0, 0.8)), ((-15.0, 2.0), (-5.0, 1.6))
CURRENT = {"profile": "power", "speed_m_s": 0.8, "direction_deg": 110.0}


def submerged(case: CaseConfig, mesh: Mesh, hydro: HydroMesh) -> Loads:
    """Loads on members that end below the surface: resultants about the origin."""
    sea = build_sea_state(case)
    frame = Frame(sea.direction_deg)
    history = assemble(case, hydro, frame, make_field(case, sea), lowest=-1.5, highest=1.5)
    nodal = history.nodal.transpose(2, 0, 1)
    force, place = nodal[:, :, :3], mesh.node_position[history.node]
    moment = (nodal[:, :, 3:] + np.cross(place[None], force)).sum(axis=1)
    return Loads(np.arange(case.time.n) * 0.1, force.sum(axis=1), moment, history)


def equilibrium(variant: str) -> float:
    """Nodal loads against the sectional force from the kinematics, distributed linearly, to round-off."""
    mesh = column(top=(5.0, -4.0, -2.0), elements=3)
    case = listed(
        [OMEGA, 2.0 * OMEGA], [0.5, 0.2], [0.0, 1.0], direction=[25.0, 60.0], water_depth_m=DEPTH,
        current=CURRENT, time={"dt_s": 0.1, "n": 100},
        wave={"order": 1, "stretching": "taylor"}, morison={"cd": CD, "cm": CM},
    )  # fmt: skip
    hydro = build_hydro_mesh(mesh, water_depth=DEPTH, longest=0.7, levels=[z for z, _ in CD + CM])
    got = submerged(case, mesh, hydro)
    a, b = mesh.node_position[mesh.member_node[0]]
    axis = (b - a) / np.linalg.norm(b - a)
    station = hydro.station
    asked = {"points_m": tuple(map(tuple, station.tolist()))}
    k = wave_kinematics(
        case.model_copy(update=asked | ({"current": None} if variant == "no current" else {}))
    )
    normal = np.eye(3) if variant == "axial too" else np.eye(3) - np.outer(axis, axis)
    v, dv = k.velocity @ normal, k.acceleration @ normal
    cd, cm = (np.interp(station[:, 2], *np.array(table).T) for table in (CD, CM))
    if variant == "one coefficient":
        cd[:], cm[:] = cd.mean(), cm.mean()
    q = RHO * AREA * cm[:, None] * dv
    q = q + 0.5 * RHO * DIAMETER * cd[:, None] * np.linalg.norm(v, axis=2, keepdims=True) * v
    step = np.linalg.norm(np.diff(station, axis=0), axis=1)
    force, moment = np.zeros_like(got.force), np.zeros_like(got.force)
    for g, w in zip(kernel.GAUSS, kernel.WEIGHT, strict=True):
        r, here = station[:-1] + g * np.diff(station, axis=0), q[:, :-1] + g * np.diff(q, axis=1)
        if variant == "lumped":
            r = station[:-1]
        force += w * np.einsum("tpc,p->tc", here, step)
        moment += w * np.einsum("tpc,p->tc", np.cross(r[None], here), step)
    return max(relative(got.force, force), relative(got.moment, moment))


# --- the surface --------------------------------------------------------------------------------------


def step_of(variants: tuple[tuple[int, int], ...]) -> float:
    """Largest step of a load, over its range, while the surface rises past the stations of an element."""
    worst, n, length = 0.0, 4001, 6.0
    for rule, stride in variants:
        size = 5 * stride + 1
        place, z = np.linspace(0.0, 1.0, size), np.linspace(-2.0, 3.0, size)
        weights, rows, q = np.empty((5, stride + 1, 6)), np.zeros((10, n)), np.empty((size, 3, n))
        kernel.segment_weights(place, length, stride, rule == 1, weights)
        eta = np.broadcast_to(np.linspace(-2.5, 3.5, n), (size, n)).copy()
        motion = np.ones((size, 4, n)) * (1.0 + 0.1 * z[:, None, None])
        axes, current = rotation(np.zeros(3), np.array([1.0, 2.0, 3.0])), np.full((size, 3), 0.2)
        coefficient = np.column_stack([5.0 + 0.1 * z, 2.0 - 0.1 * z, 0.0 * z + 0.3, 0.0 * z + 0.1])
        sectional(motion, axes, coefficient, current, q)
        surface_loads(
            q, motion, z, eta, rule, stride, axes, coefficient, current, place, length, weights, rows
        )
        worst = max(worst, float((np.abs(np.diff(rows, axis=1)).max(axis=1) / np.ptp(rows, axis=1)).max()))
    return worst


# --- Gauss points -------------------------------------------------------------------------------------


def gauss_error(variant: str) -> float:
    """Error of the base shear and moment of a submerged member, over that of the 1 m rule."""
    mesh = column(top=(6.0, 3.0, -2.0), elements=4)
    omega = np.array([0.5, 0.8, 1.1, 1.5, 2.0])
    case = listed(
        omega, [1.0, 0.8, 0.4, 0.2, 0.1], [0.0, 1.0, 2.0, 3.0, 4.0], water_depth_m=DEPTH,
        time={"dt_s": 0.1, "n": 600}, wave={"order": 1, "stretching": "taylor"},
    )  # fmt: skip

    def of(longest: float, below: float | None = None) -> tuple[np.ndarray, int]:
        hydro = build_hydro_mesh(mesh, water_depth=DEPTH, longest=longest, gauss_below=below)
        got = submerged(case, mesh, hydro)
        return np.concatenate([got.force, 0.1 * got.moment], axis=1), len(hydro.station)

    truth, rule, points = of(0.05)[0], of(1.0), of(1.0, 0.0)
    assert 2.5 * points[1] < rule[1]
    other = points[0] if variant == "gauss" else of(float(variant))[0]
    return float(np.abs(other - truth).max() / np.abs(rule[0] - truth).max())


PROOFS = (
    jacket_proof("A", 1, 2e-4),
    jacket_proof("A", 2, 2e-4),
    jacket_proof("C", 2, 1e-3),
    Proof(
        key="upright-cylinder",
        claim="Inertia force on an upright cylinder up to the moving surface, any heading",
        against="closed form, 2 rho A a g sin(wt) sinh k(d + eta) / cosh kd",
        error=upright,
        right={},
        wrong={
            "up to still water": {"moving": False},
            "segments on or off by their middle": {"morison": {"surface": "midpoint"}},
            "drag left in": {"morison": {"cd": 1.0}},
        },
        allowed=2e-6,
        reason="0.05 m elements, error of the trapezoidal rule (k dx)^2 / 12",
    ),
    Proof(
        key="growth-widens-inertia-and-drag",
        claim="Loads are on the diameter with growth inside its zone only",
        against="closed form over the zone and the rest",
        error=growth,
        right=True,
        wrong={"clean member": False},
        allowed=2e-6,
        reason="as the upright cylinder",
    ),
    Proof(
        key="beam-under-uniform-load",
        claim="A uniform load on a clamped element gives q L / 2 and q L^2 / 12, both distributions",
        against="textbook",
        error=uniform_beam,
        right=False,
        wrong={"point forces at the middles": True},
        allowed=1e-13,
        reason="round-off",
    ),
    rate_proof("constant", 2.0, BY_MIDDLE | {"parabolas": ("quadratic", "moving")}),
    rate_proof("linear", 2.0, BY_MIDDLE | {"parabolas": ("quadratic", "moving")}),
    rate_proof("quadratic", 4.0, BY_MIDDLE | {"straight lines": ("linear", "moving")}),
    Proof(
        key="equilibrium-of-nodal-loads",
        claim="Nodal loads balance the distributed force: three axes, current, coefficients by level",
        against="sectional forces from the kinematics, integrated apart",
        error=equilibrium,
        right="",
        wrong={name: name for name in ("lumped", "axial too", "no current", "one coefficient")},
        allowed=1e-11,
        reason="round-off",
    ),
    Proof(
        key="no-step-at-the-surface",
        claim="No load jumps when a station wets or dries, for all three distributions",
        against="a surface that rises steadily, 3333 samples per element",
        error=step_of,
        right=((0, 1), (1, 1), (0, 2)),
        wrong={"segments on or off by their middle": ((2, 1),), "and with three nodes": ((2, 2),)},
        allowed=1e-2,
        reason="a steady ramp is 3e-4 per sample, the shapes are up to some ten times steeper",
    ),
    Proof(
        key="gauss-points",
        claim="Gauss points on a submerged member: a tenth of the error of the 1 m rule at 0.4 of its points",
        against="0.05 m elements",
        error=gauss_error,
        right="gauss",
        wrong={"1 m elements": "1.0", "as few equal elements": "3.0"},
        allowed=0.1,
        reason="the ratio claimed, as one of largest errors",
    ),
)
