"""The OC4 turbine under waves: equilibrium, and reduced models against the unreduced one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from owt_model.config import CaseConfig, parse_case
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.assembly import assemble, element_transformation
from owt_structure_node.core.recovery import end_sections
from owt_structure_node.core.reduction import reduce
from owt_structure_node.core.stage import (
    Response,
    ResponseModel,
    build_response_model,
    initial_state,
    step,
)
from owt_wave_node.core.stage import WaveStage, build_wave_stage
from proofs.cases import relative
from proofs.registry import Proof

ALPHA, BETA = 0.027, 0.002
EVERY = "CB936"
#: Sea states of the load-case table: Hs in m, Tp in s, direction the waves come from in degrees from north.
SEAS = ((8.25, 11.5, 270.0), (4.25, 9.25, 270.0), (0.75, 6.34, 270.0), (1.75, 9.06, 330.0))


@cache
def jacket() -> Mesh:
    return build_mesh(load_structure("oc4-thesis"))


def case_of(reduction: str, sea: tuple[float, float, float], n: int) -> CaseConfig:
    """A case at 0.1 s, waves and response, in one block."""
    hs, tp, metocean = sea
    state = {"hs_m": hs, "tp_s": tp, "direction_deg": (180.0 - metocean) % 360.0, "seed": 1}
    structure = {"model": "oc4-thesis", "reduction": reduction, "dt_s": 0.1}
    structure |= {"damping": {"alpha": ALPHA, "beta": BETA}}
    return parse_case(
        {"sea_state": state, "time": {"dt_s": 0.1, "n": n}, "structure": structure, "stream": {"block": n}}
    )


@lru_cache(maxsize=1)
def waves(sea: tuple[float, float, float], n: int) -> WaveStage:
    return build_wave_stage(case_of("full", sea, n), jacket())


@cache
def model_without_loads(reduction: str) -> ResponseModel:
    return build_response_model(case_of(reduction, SEAS[0], 600), jacket(), None)


def respond(reduction: str, sea: tuple[float, float, float], n: int, *, fixed_ends: bool = True) -> Response:
    """The response to a sea, its load vectors taken from the same sea."""
    stage = waves(sea, n)
    load = stage.load_block(0)
    if not fixed_ends:
        load = replace(load, fixed_end=0.0 * load.fixed_end)
    if "M" in reduction:
        model = build_response_model(case_of(reduction, sea, n), jacket(), stage.load_basis(20))
    else:
        model = model_without_loads(reduction)
    return step(model, initial_state(model), load)[1]


def arms() -> np.ndarray:
    """Places of the nodes above the middle of the mud line [node, 3]."""
    place, foot = jacket().node_position, feet()
    return np.asarray(place - np.array([0.0, 0.0, place[foot][0, 2]]))


def feet() -> np.ndarray:
    """Whether each node is clamped to the ground."""
    mesh = jacket()
    return np.asarray((mesh.node_dof < 0).all(axis=1) & (mesh.node_leader == np.arange(mesh.n_nodes)))


def lifted(force: np.ndarray, moment: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Upward force, and moments about the level axes in the mud line [time, 3]."""
    return np.column_stack([force[:, 2], (moment + np.cross(arm, force))[:, :2]])


def ground(response: Response) -> np.ndarray:
    """What the ground exerts, from the stresses at the feet of the piles, whose shear forces are level."""
    mesh, arm, stress = jacket(), arms(), response.stress
    ends, total = end_sections(mesh), np.zeros((len(stress.axial), 3))
    for end in np.flatnonzero(feet()[mesh.element_node[ends.element, ends.side]]):
        axes = element_transformation(mesh)[ends.element[end], :3, :3]
        assert abs(axes[0, 2]) == 1.0  # an upright pile
        local = [stress.axial[:, end], stress.bending_y[:, end], -stress.bending_z[:, end]]
        normal, m_y, m_z = ends.sign[end] * np.array(local) / ends.factor[[0, 1, 1], end, None]
        moment = m_y[:, None] * axes[1] + m_z[:, None] * axes[2]
        node = mesh.element_node[ends.element[end], ends.side[end]]
        total += lifted(normal[:, None] * axes[0], moment, arm[node])
    return total


def support_error(variant: str) -> float:
    """Imbalance of ground, waves, inertia and damping in time, over the largest load by the waves."""
    reduction = variant if variant.startswith("CB") else EVERY
    response = respond(reduction, SEAS[0], 600, fixed_ends=variant != "no fixed-end forces")
    load, arm, mesh = waves(SEAS[0], 600).load_block(0), arms(), jacket()
    parts = [lifted(load.nodal[:, i, :3], load.nodal[:, i, 3:], arm[n]) for i, n in enumerate(load.node)]
    applied = np.sum(parts, axis=0)
    rigid = np.zeros((mesh.n_dof, 3))  # up, and turning about the level axes
    for node in np.flatnonzero((mesh.node_dof >= 0).all(axis=1)):
        x, y, z = arm[node]
        rigid[mesh.node_dof[node]] = np.transpose(
            [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0, -z, y, 1.0, 0.0, 0.0], [z, 0.0, -x, 0.0, 1.0, 0.0]]
        )
    assembly = assemble(mesh)
    shapes = reduce(assembly, reduction).shapes
    m, k = (shapes.T @ (a @ rigid) for a in (assembly.mass, assembly.stiffness))
    inertia, damping = response.modal.acceleration @ m, response.modal.velocity @ (ALPHA * m + BETA * k)
    off = ground(response) + applied - inertia - damping
    off += {"no inertia": inertia, "no damping": damping}.get(variant, 0.0)
    scale = np.abs(applied).max(axis=0)
    return float(max(np.abs(off[:, 0]).max() / scale[0], np.abs(off[:, 1:]).max() / scale[1:].max()))


def complete_error(reduction: str) -> float:
    """Largest difference of stress, energies and motion above the interface from the unreduced model."""
    full, found = respond("full", SEAS[0], 600), respond(reduction, SEAS[0], 600)
    above = [*range(6), *range(-len(jacket().tower_node) * 6, 0)]
    worst = relative(found.modal.displacement[:, above], full.modal.displacement)
    worst = max(worst, relative(found.modal.velocity[:, above], full.modal.velocity))
    for part, names in (
        ("stress", ("axial", "bending_y", "bending_z")),
        ("energy", ("potential", "kinetic")),
    ):
        for name in names:
            pair = (getattr(getattr(response, part), name) for response in (found, full))
            worst = max(worst, relative(*pair))
    return worst


@cache
def energy_errors(sea: tuple[float, float, float]) -> dict[str, float]:
    """Error of mean or standard deviation of the potential energy by 240 s of a sea, of every reduction."""
    exact, errors = respond("full", sea, 2400).energy.potential, {}
    for reduction in ("CB10M10", "M20", "CB20", "CB00"):
        found = respond(reduction, sea, 2400).energy.potential
        errors[reduction] = max(abs(found.mean() / exact.mean() - 1.0), abs(found.std() / exact.std() - 1.0))
    return errors


def energy_error(reductions: tuple[str, ...]) -> float:
    """The largest of them over all seas."""
    return max(energy_errors(sea)[reduction] for sea in SEAS for reduction in reductions)


PROOFS = (
    Proof(
        key="jacket-equilibrium",
        claim="Stresses at the feet of the OC4 piles balance waves, inertia and damping at every instant",
        against="upward force and overturning moments, sea of Hs 8.25 m, 60 s, all modes kept",
        error=support_error,
        right="right",
        wrong={
            "fixed-end forces left out": "no fixed-end forces",
            "inertia left out": "no inertia",
            "damping left out": "no damping",
            "20 modes": "CB20",
        },
        allowed=2e-6,
        reason="vertical loads are a hundredth of the others; round-off of the highest modes' accelerations",
    ),
    Proof(
        key="all-modes-are-the-full-model",
        claim="Craig-Bampton with all modes gives the response of the unreduced OC4 turbine in time",
        against="stresses, energies, motion of interface and tower, sea of Hs 8.25 m, 60 s",
        error=complete_error,
        right=EVERY,
        wrong={"36 of 936 modes left out": "CB900", "half of them": "CB468"},
        allowed=2e-6,
        reason="round-off of two eigenvalue problems whose squared frequencies span ten decades",
    ),
    Proof(
        key="reduced-energy",
        claim="CB10M10 and M20 give mean and deviation of the potential energy within 0.1 % (figure 6.2)",
        against="unreduced model, four sea states of the table, vectors of the same sea, 240 s, seed 1",
        error=energy_error,
        right=("CB10M10", "M20"),
        wrong={"Guyan": ("CB00",), "modes only": ("CB20",)},
        allowed=1e-3,
        reason="the thesis finds 0.08 % over its table",
    ),
)
