"""Thesis tables B.1, B.2 and B.3: frequencies and damping of ``oc4-thesis``, beside the print.

Modes of the reduced models are found again in the unreduced one by their shapes: modes 13 to 15 lie within
7 mHz, an index says nothing there.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csc_array

from owt_campaign.standard_load import standard_load_basis
from owt_model.mesh import Mesh, build_mesh
from owt_model.sensitivity import SENSITIVITY_MODELS, sensitivity_model
from owt_model.structure import case_structure, load_structure
from owt_structure_node.core.assembly import Assembly, assemble
from owt_structure_node.core.eigen import eigen_report
from owt_structure_node.core.modes import dense_modes, hertz, lowest_modes
from owt_structure_node.core.reduction import reduce

__all__ = [
    "MODEL",
    "PRINTED_CLASSES",
    "REDUCTIONS",
    "EigenStudy",
    "eigen_study",
    "quarter_turn_classes",
    "thesis_tables",
]

MODEL = "oc4-thesis"
#: Reductions of table B.1, and how many modes it lists.
REDUCTIONS, COUNT = ("CB00", "CB20", "M20", "CB10M10"), 20
#: Modes of table B.2, and the classes that match the print's frequencies best.
FIXED_COUNT, PRINTED_CLASSES = 10, "EEBABEEABA"
#: Modes of the unreduced model among which those of the reduced ones are looked for.
SEARCHED = 60
#: Share of a mode's motion that a quarter turn must keep, or reverse.
ALIKE = 0.9


@dataclass(frozen=True)
class EigenStudy:
    """What the three tables hold, from this code.

    Attributes
    ----------
    table_b1 : dict
        Frequencies in Hz of the unreduced model (``full``) and of each reduction, ascending.
    match : dict
        For each reduction and mode: index of the mode of the unreduced model with the most similar shape, and
        its similarity (modal assurance criterion in the mass).
    table_b2 : list of float
        Frequencies in Hz of the jacket with the interface held.
    class_b2 : str
        Class of each under a quarter turn about z: A alike, B reversed, E one of a pair.
    table_b3 : dict
        ``frequency_hz`` (damped) and ``logdec_percent`` of each sensitivity model.
    """

    table_b1: dict[str, list[float]]
    match: dict[str, list[tuple[int, float]]]
    table_b2: list[float]
    class_b2: str
    table_b3: dict[str, dict[str, list[float]]]

    def as_json(self) -> dict[str, Any]:
        """Plain data; the tables under the names and in the layout of the print's data file."""
        return {
            "table_B1": self.table_b1,
            "table_B2": self.table_b2,
            "table_B3": self.table_b3,
            "class_B2": self.class_b2,
            "match_B1": {name: [list(pair) for pair in pairs] for name, pairs in self.match.items()},
        }


def thesis_tables() -> dict[str, Any]:
    """Tables B.1 to B.3 as printed."""
    text = (resources.files("owt_campaign") / "data" / "thesis_tables.json").read_text(encoding="utf-8")
    tables: dict[str, Any] = json.loads(text)
    return tables


def eigen_study() -> EigenStudy:
    """Compute the tables.

    Raises
    ------
    ComputationError
        If an eigenvalue problem fails.
    """
    structure = load_structure(MODEL)
    assembly = assemble(build_mesh(structure))
    omega2, shapes = lowest_modes(assembly.stiffness, assembly.mass, SEARCHED)
    basis = standard_load_basis(structure, COUNT)
    table, match = {"full": hertz(omega2[:COUNT])}, {}
    for name in REDUCTIONS:
        reduced = reduce(assembly, name, basis)
        found, modes = dense_modes(reduced.stiffness, reduced.mass)
        table[name] = hertz(found[:COUNT])
        match[name] = _matched(assembly, shapes, reduced.shapes @ modes[:, :COUNT])
    fixed, class_b2 = _fixed_interface(assembly)
    return EigenStudy(table, match, fixed, class_b2, {name: _damped(name) for name in SENSITIVITY_MODELS})


def _matched(
    assembly: Assembly, full: Float[np.ndarray, "dof mode"], reduced: Float[np.ndarray, "dof count"]
) -> list[tuple[int, float]]:
    similarity = (full.T @ (assembly.mass @ reduced)) ** 2
    row, column = linear_sum_assignment(similarity, maximize=True)
    place = dict(zip(column.tolist(), row.tolist(), strict=True))
    return [(place[i], float(similarity[place[i], i])) for i in range(reduced.shape[1])]


def _fixed_interface(assembly: Assembly) -> tuple[list[float], str]:
    """Frequencies of the jacket with the interface held, and the classes of their modes."""
    n = assembly.internal
    k_ii, m_ii = (csc_array(a[:n, :n]) for a in (assembly.jacket_stiffness, assembly.jacket_mass))
    omega2, inside = lowest_modes(k_ii, m_ii, FIXED_COUNT)
    shapes = np.zeros((assembly.mesh.n_dof, FIXED_COUNT))
    shapes[:n] = inside
    motion = np.asarray(assembly.expansion @ shapes).reshape(assembly.mesh.n_nodes, 6, -1)
    return hertz(omega2), quarter_turn_classes(assembly.mesh, motion)


def quarter_turn_classes(mesh: Mesh, motion: Float[np.ndarray, "node 6 mode"]) -> str:
    """Class of each mode of a structure that a quarter turn about z leaves alike.

    Parameters
    ----------
    mesh : Mesh
        The structure.
    motion : float array [node, 6, mode]
        Shapes at all nodes.

    Returns
    -------
    str
        One letter per mode: A alike, B reversed, E neither (one of a pair).
    """
    joints = len(mesh.structure.joints)
    position = mesh.node_position[:joints]
    turned = position[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]
    image = [int(np.abs(position - point).sum(axis=1).argmin()) for point in turned]
    classes = ""
    for shape in np.moveaxis(motion[:joints, :3], -1, 0):
        rotated = shape[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]
        likeness = float(np.sum(rotated * shape[image]) / np.sum(shape**2))
        classes += "A" if likeness > ALIKE else "B" if likeness < -ALIKE else "E"
    return classes


def _damped(name: str) -> dict[str, list[float]]:
    """Damped frequencies and log decrements of a sensitivity model."""
    config = sensitivity_model(name)
    report = eigen_report(case_structure(config), damping=config.damping, n_modes=COUNT)
    return {"frequency_hz": report["damped_frequencies_hz"], "logdec_percent": report["logdec_percent"]}
