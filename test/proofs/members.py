"""Diffraction, buoyancy, loads along members and on their ends, damping by the drag on relative velocity."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from scipy.special import h2vp, hankel2, jv, jvp, yvp

from owt_model.config import parse_case
from owt_model.contracts import LoadBasis
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import parse_structure
from owt_model.structure_config import Damping
from owt_structure_node.core.response import build_modal_model, model_damping
from owt_wave_node.core.buoyancy import buoyancy
from owt_wave_node.core.diffraction import inertia_ratio
from owt_wave_node.core.hydro_damping import drag_damping, relative_force
from owt_wave_node.core.hydro_mesh import case_hydro_mesh
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.loads import jacket_loads
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state, waves
from proofs.cases import column, listed, oc4, relative
from proofs.registry import Proof

RHO, G, DEPTH = 1025.0, 9.81, 20.0
STEEL = {"youngs_modulus_pa": 2.1e11, "shear_modulus_pa": 8.1e10, "density_kg_m3": 7850.0}


# --- diffraction --------------------------------------------------------------------------------------


def ring_error(variant: str) -> float:
    """Inertia coefficient against the pressure of the diffraction potential, summed round the cylinder.

    With exp(i w t) the potential of the incident wave exp(-i k x) and of its diffraction is, on r = a,
    sum e_n (-i)^n [J_n - J_n' H_n / H_n'] cos n theta, H of the second kind: no flow through the wall.
    """
    theta = 2.0 * np.pi * np.arange(64) / 64
    worst = 0.0
    for ka in (0.01, 0.3, 1.0, 2.5):
        n = np.arange(24)[:, None]
        scattered = jvp(n, ka) / h2vp(n, ka) * hankel2(n, ka)
        potential = (
            np.where(n > 0, 2.0, 1.0) * (-1j) ** n * (jv(n, ka) - scattered) * np.cos(n * theta)
        ).sum(0)
        # Force -rho i w phi integrated, over rho pi a^2 times the acceleration w k of the unit potential.
        force = 1j * np.mean(potential * np.cos(theta)) * 2.0 / ka
        found = {
            "right": 2.0 * inertia_ratio(np.array([ka]))[0],
            "conjugate": 2.0 * np.conj(inertia_ratio(np.array([ka]))[0]),
            "long waves": 2.0,
        }[variant]
        worst = max(worst, abs(complex(found) - force))
    return worst


def cylinder_error(variant: str) -> float:
    """Total force on a cylinder of 8 m at three periods, 4 rho g a / k^2 tanh(kd) / |H1'| and its phase."""
    sections = {"tube": {"diameter_m": 8.0, "thickness_m": 0.1} | STEEL}
    mesh, worst = column(sections=sections), 0.0
    for period in (4.0, 8.0, 12.0):
        omega, a = 2.0 * math.pi / period, 1e-3
        case = listed(
            omega, a, 0.0, water_depth_m=DEPTH, time={"dt_s": period / 40.0, "n": 40},
            wave={"order": 1, "stretching": "none"},
            morison={
                "cd": 0.0, "discretisation_m": 0.25, "distribution": "quadratic",
                "diffraction": "none" if variant == "none" else "maccamy-fuchs",
            },
        )  # fmt: skip
        got = jacket_loads(case, mesh)
        k = float(waves(build_sea_state(case)).wavenumber[0])
        x = 4.0 * k
        depth = 1.0 if variant == "deep water" else math.tanh(k * DEPTH)
        size = 4.0 * RHO * G * a / k**2 * depth / math.hypot(jvp(1, x), yvp(1, x))
        phase = 0.5 * math.pi if variant == "no phase" else math.atan2(yvp(1, x), jvp(1, x))
        exact = size * np.cos(omega * got.t + phase)
        worst = max(worst, relative(got.force[:, 0], exact))
    return worst


# --- a free member under water ------------------------------------------------------------------------


def stub(head: tuple[float, float, float], *, flooded: bool = False) -> Mesh:
    """A column with a second, free member that starts at its middle and ends at `head`."""
    data: dict[str, Any] = {
        "name": "stub", "elements_per_member": 3, "mudline_z_m": -DEPTH,
        "sections": {
            "tube": {"diameter_m": 1e-3, "thickness_m": 1e-4} | STEEL,
            "arm": {"diameter_m": 1.2, "thickness_m": 0.05} | STEEL,
        },
        "joints": {"foot": [0, 0, -DEPTH], "knee": [0, 0, -8.0], "top": [0, 0, 8.0], "tip": list(head)},
        "members": {
            "lower": {"joints": ["foot", "knee"], "section": "tube"},
            "upper": {"joints": ["knee", "top"], "section": "tube"},
            "arm": {"joints": ["knee", "tip"], "section": "arm", "flooded": flooded},
        },
        "supports": {"foot": [True] * 6},
        "interface": {"joints": ["top"], "reference_m": [0, 0, 8.0]},
        "flooding": {"density_kg_m3": RHO, "free_surface_z_m": 0.0},
    }  # fmt: skip
    return build_mesh(parse_structure(data, source="test"))


def along_error(variant: str) -> float:
    """Force along a free arm: added mass and drag along it, and on its end disc, from the kinematics."""
    knee, tip = np.array([0.0, 0.0, -8.0]), np.array([4.0, 3.0, -4.0])
    case = listed(
        [0.7, 1.3], [1.0, 0.4], [0.0, 2.0], direction=[10.0, 50.0], water_depth_m=DEPTH,
        current={"speed_m_s": 0.5, "direction_deg": 200.0}, time={"dt_s": 0.1, "n": 200},
        wave={"order": 1, "stretching": "taylor"},
        morison={"cd": 0, "cm": 0, "axial_cd": 0.2, "axial_ca": 0.1, "end_cd": 0.8, "end_ca": 0.9,
                 "distribution": "quadratic"},
    )  # fmt: skip
    got = jacket_loads(case, stub(tuple(tip))).force
    length, d = float(np.linalg.norm(tip - knee)), 1.2
    axis = (tip - knee) / length
    x, w = np.polynomial.legendre.leggauss(8)
    points = np.vstack([knee + np.outer(0.5 + 0.5 * x, tip - knee), tip])
    k = wave_kinematics(case.model_copy(update={"points_m": tuple(map(tuple, points.tolist()))}))
    v, a = k.velocity @ axis, k.acceleration @ axis
    size = np.linalg.norm(k.velocity, axis=2) if variant == "whole speed" else np.abs(v)
    area = math.pi * d**2 / 4.0
    line = RHO * 0.1 * area * a + 0.5 * RHO * 0.2 * d * size * v
    force = line[:, :-1] @ (0.5 * length * w)
    ball = (4.0 if variant == "whole sphere" else 2.0) / 3.0 * math.pi * (0.5 * d) ** 3
    if variant != "no end":
        force = force + 0.5 * RHO * 0.8 * area * np.abs(v[:, -1]) * v[:, -1] + RHO * 0.9 * ball * a[:, -1]
    return relative(got, np.outer(force, axis))


# --- buoyancy -----------------------------------------------------------------------------------------


def arm_buoyancy(flooded: bool) -> float:
    """Force and moment about the knee of a submerged arm, over rho g V and its lever."""
    tip = (4.0, 3.0, -4.0)
    mesh = stub(tip, flooded=flooded)
    case = parse_case({"water_depth_m": DEPTH})
    load = buoyancy(case, mesh)
    knee = np.array([0.0, 0.0, -8.0])
    half = 0.5 * (np.array(tip) - knee)
    weight = RHO * G * math.pi * 1.2**2 / 4.0 * 2.0 * float(np.linalg.norm(half))
    moment = (load[:, 3:] + np.cross(mesh.node_position - knee, load[:, :3])).sum(axis=0)
    expected = np.concatenate([[0.0, 0.0, weight], np.cross(half, [0.0, 0.0, weight])])
    return relative(np.concatenate([load[:, :3].sum(axis=0), moment]), expected)


def jacket_buoyancy(growth: bool) -> float:
    """Total buoyancy of the OC4 jacket over the published 3.873 MN."""
    case = parse_case({"morison": {"marine_growth": growth}})
    return abs(float(buoyancy(case, oc4())[:, 2].sum()) / 3.873e6 - 1.0)


# --- damping by relative velocity ---------------------------------------------------------------------


@cache
def damping_rates(moving: bool) -> tuple[float, float]:
    """Decay of a column's first mode in waves, drag on the relative velocity, and the linear damping, in 1/s.

    Two motions that start a little apart approach each other at the rate of the damping, whatever the waves
    do to both. Integrated in numpy, station by station, by Runge and Kutta's method.
    """
    mesh = column(top=(0.0, 0.0, 10.0), elements=12)
    case = listed(
        [0.6, 0.9, 1.4], [1.2, 0.8, 0.3], [0.0, 1.0, 2.0], water_depth_m=DEPTH,
        time={"dt_s": 0.02, "n": 3000},
        wave={"order": 1, "stretching": "constant"}, morison={"discretisation_m": 0.5},
    )  # fmt: skip
    sea = build_sea_state(case)
    frame, field = Frame(sea.direction_deg), make_field(case, sea)
    hydro = case_hydro_mesh(case, mesh, lowest=-4.0)
    damping = drag_damping(case, hydro, frame, field, lowest=-4.0, highest=4.0)
    basis = LoadBasis(
        model_hash=mesh.structure.content_hash, node=hydro.node, vectors=np.zeros((0, hydro.node.size, 6)),
        singular_values=np.zeros(0), total_variance=1.0, mean=np.zeros((hydro.node.size, 6)), snapshots=1,
        damping=damping,
    )  # fmt: skip
    model = build_modal_model(mesh, "full")
    shape = model.node_basis[:, 0, :]
    mode = int(np.abs(shape[:, :2]).max(axis=0).argmax())
    predicted = float(model_damping(model, Damping(alpha=0.0, beta=0.0), basis).diagonal[mode])
    z = mesh.node_position[:13, 2]
    order = np.argsort(z)
    level = np.linspace(-DEPTH, 4.0, 97)
    phi = np.interp(level, z[order], shape[:13, mode][order])
    points = tuple((0.0, 0.0, float(s)) for s in level)
    k = wave_kinematics(case.model_copy(update={"points_m": points}))
    wet = k.eta1[:, :1] >= level
    weight = np.full(level.size, level[1] - level[0])
    weight[[0, -1]] *= 0.5
    square = float(model.omega_squared[mode])

    def rate(q: np.ndarray, i: int) -> np.ndarray:
        body = np.zeros((2, level.size, 3))
        body[..., 0] = q[:, 1, None] * phi if moving else 0.0
        at_rest = np.zeros_like(body)
        water = (np.broadcast_to(k.velocity[i], body.shape), at_rest)
        force = relative_force(
            water, (body, at_rest), axis=np.array([0.0, 0.0, 1.0]), diameter=1.5, cd=1.0, cm=2.0, density=RHO
        )
        load = (force[..., 0] * wet[i] * weight * phi).sum(axis=1)
        return np.stack([q[:, 1], load - square * q[:, 0]], axis=1)

    q, h, size = np.array([[0.0, 0.0], [1e-3, 0.0]]), 0.04, []
    for i in range(0, 2998, 2):
        k1 = rate(q, i)
        k2 = rate(q + 0.5 * h * k1, i + 1)
        k3 = rate(q + 0.5 * h * k2, i + 1)
        q = q + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(q + h * k3, i + 2))
        gap = q[1] - q[0]
        size.append(math.sqrt(square * gap[0] ** 2 + gap[1] ** 2))
    found = -2.0 * math.log(size[-1] / size[0]) / (h * (len(size) - 1))
    return found, predicted


def damping_error(variant: str) -> float:
    """Relative error of the linear damping; without its direction it would be half in plane flow."""
    found, predicted = damping_rates(variant != "fixed member")
    return abs(found / (0.5 * predicted if variant == "speed alone" else predicted) - 1.0)


PROOFS = (
    Proof(
        key="diffraction-coefficient",
        claim="Inertia coefficient of MacCamy and Fuchs with its phase, ka from 0.01 to 2.5",
        against="pressure of the diffraction potential summed round the cylinder",
        error=ring_error,
        right="right",
        wrong={"waves that come in": "conjugate", "2 for all waves": "long waves"},
        allowed=1e-9,
        reason="round-off of 24 Bessel functions",
    ),
    Proof(
        key="diffraction-force",
        claim="Force of diffracted waves on an upright cylinder of 8 m, kd from 0.8 to 5",
        against="closed form 4 rho g a / k^2 tanh kd / |H1'(ka)| with its phase",
        error=cylinder_error,
        right="right",
        wrong={"no diffraction": "none", "deep water": "deep water", "no phase": "no phase"},
        allowed=2e-3,
        reason="the closed form ends at still water, the wave of 1 mm at its surface; k a = 2.5e-4",
    ),
    Proof(
        key="loads-along-a-member",
        claim="Added mass and drag along a free member and on its end, short-crested waves and current",
        against="kinematics at Gauss points, integrated apart",
        error=along_error,
        right="right",
        wrong={name: name for name in ("whole speed", "whole sphere", "no end")},
        allowed=1e-3,
        reason="parabolas over 1 m against |v| v, whose slope jumps where v changes sign",
    ),
    Proof(
        key="buoyancy-of-a-closed-tube",
        claim="Buoyancy of a submerged member is rho g V, upwards through its middle",
        against="Archimedes",
        error=arm_buoyancy,
        right=False,
        wrong={"flooded": True},
        allowed=1e-5,
        reason="the thin column that carries the arm has 1e-6 of its volume",
    ),
    Proof(
        key="buoyancy-of-the-jacket",
        claim="Buoyancy of the OC4 jacket with growth, flooded legs, piles that stand on the bed",
        against="3.873 MN, published for the model in HydroDyn",
        error=jacket_buoyancy,
        right=True,
        wrong={"without growth": False},
        allowed=3e-3,
        reason="volumes differ by 0.07 % (661.60 against 661.15 m3 submerged), buoyancy by 0.16 %",
    ),
    Proof(
        key="damping-by-relative-velocity",
        claim="Damping of a column's first mode by the drag on its own motion, linearised",
        against="decay of a small motion with drag on the relative velocity, integrated in time",
        error=damping_error,
        right="right",
        wrong={"fixed member": "fixed member", "speed alone, without its direction": "speed alone"},
        allowed=0.02,
        reason="the time integration alone damps 1.6e-2 of that",
    ),
)
