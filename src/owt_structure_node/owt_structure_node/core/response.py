"""The assembled reduced model in its own modes: what the time integration and the recovery work with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBasis, ReducedDescription
from owt_model.mesh import Mesh
from owt_model.reduction_name import parse_reduction
from owt_model.structure_config import Damping
from owt_structure_node.core.assembly import DOF_NAME, Assembly, assemble
from owt_structure_node.core.auto import Target, chosen_reduction
from owt_structure_node.core.damping import (
    ModalDamping,
    all_vectors,
    lowest_damped,
    modal_damping,
)
from owt_structure_node.core.energies import SUBSTRUCTURES
from owt_structure_node.core.modes import dense_modes
from owt_structure_node.core.reduction import Interior, solve_interior
from owt_structure_node.core.sim import StaticImprovement

__all__ = [
    "MAX_REPORTED_MODES",
    "ModalModel",
    "StructureParts",
    "build_modal_model",
    "describe",
    "model_damping",
    "structure_parts",
]

#: Modes whose frequencies and energies are reported one by one; totals are over all modes.
MAX_REPORTED_MODES = 256


@dataclass(frozen=True)
class ModalModel:
    """Modes of the assembled reduced model.

    Attributes
    ----------
    assembly : Assembly
        The unreduced structure.
    reduction : str
        Name of the reduction.
    omega_squared : float array [mode]
        In rad2/s2, ascending.
    basis : float array [dof, function]
        Shapes over the free degrees of freedom of the unreduced structure: the reduction basis, whose
        internal part a few functions span; for ``full`` the modes themselves.
    amplitude : float array [mode, function], or None
        Amplitudes of the basis functions in each mass-normalised mode; None if those are the modes.
    coordinate : float array [mode, coordinate]
        Generalised coordinates per unit amplitude of each mode.
    coordinate_name : tuple of str
    notes : tuple of str
        What the basis has less than was asked for, one line each.
    improvement : StaticImprovement, optional
        Static response of what the basis leaves out, where asked for.
    """

    assembly: Assembly
    reduction: str
    omega_squared: Float[np.ndarray, " mode"]
    basis: Float[np.ndarray, "dof function"]
    amplitude: Float[np.ndarray, "mode function"] | None
    coordinate: Float[np.ndarray, "mode coordinate"]
    coordinate_name: tuple[str, ...]
    notes: tuple[str, ...] = ()
    improvement: StaticImprovement | None = None

    @property
    def shapes(self) -> Float[np.ndarray, "dof mode"]:
        """Mass-normalised mode shapes over the free degrees of freedom of the unreduced structure."""
        return self.basis if self.amplitude is None else self.basis @ self.amplitude.T

    @property
    def node_basis(self) -> Float[np.ndarray, "node 6 function"]:
        """Basis functions at all nodes of the mesh, supports and interface joints included."""
        motion = self.assembly.expansion @ self.basis
        return np.asarray(motion.reshape(self.assembly.mesh.n_nodes, 6, -1))

    @property
    def frequency_hz(self) -> Float[np.ndarray, " mode"]:
        """Undamped natural frequencies in Hz."""
        return np.asarray(np.sqrt(self.omega_squared) / (2.0 * np.pi))


@dataclass(frozen=True)
class StructureParts:
    """What models of one structure share, whatever their loads: matrices, static reduction, lowest modes.

    ``interior`` has a mode more than the reduction keeps; None where none is computed from the start.
    """

    assembly: Assembly
    interior: Interior | None


def structure_parts(mesh: Mesh, reduction: str) -> StructureParts:
    """Assemble a structure and solve what a named reduction of it needs before the loads are known.

    Raises
    ------
    InputError, ComputationError
        As :func:`owt_structure_node.core.reduction.solve_interior`.
    """
    assembly, name = assemble(mesh), parse_reduction(reduction)
    if name.full or name.auto or name.fixed_interface_modes > assembly.internal:
        return StructureParts(assembly, None)
    modes = min(name.fixed_interface_modes + 1, assembly.internal)
    return StructureParts(assembly, solve_interior(assembly, modes))


def build_modal_model(
    mesh: Mesh,
    reduction: str,
    basis: LoadBasis | None = None,
    target: Target | None = None,
    parts: StructureParts | None = None,
) -> ModalModel:
    """Assemble, reduce and decouple.

    ``full`` decouples the unreduced structure by a dense eigenvalue problem over all degrees of freedom:
    seconds and some 100 MiB for the OC4 jacket. Its generalised coordinates are those of the transition piece
    and of the tower, as in every reduction; the internal ones are what the member stresses come from.

    Parameters
    ----------
    mesh : Mesh
        The structure.
    reduction : str
        As :mod:`owt_model.reduction_name` lists.
    basis : LoadBasis, optional
        Load vectors for the augmentation.
    target : Target, optional
        What ``auto`` chooses for; other reductions are held against its time step.
    parts : StructureParts, optional
        Of this structure and reduction, where they are known.

    Raises
    ------
    InputError, ComputationError
        As :func:`owt_structure_node.core.auto.chosen_reduction` and the eigenvalue solution.
    """
    assembly = assemble(mesh) if parts is None else parts.assembly
    if reduction == "full":
        omega2, shapes = dense_modes(assembly.stiffness.toarray(), assembly.mass.toarray())
        nodes = [mesh.transition_piece, *mesh.tower_node]
        names = [f"{mesh.node_name[node]}.{direction}" for node in nodes for direction in DOF_NAME]
        coordinate = np.ascontiguousarray(shapes[mesh.node_dof[nodes].reshape(-1)].T)
        return ModalModel(assembly, reduction, omega2, shapes, None, coordinate, tuple(names))
    reduced, notes = chosen_reduction(
        assembly, reduction, basis, target, None if parts is None else parts.interior
    )
    omega2, modes = dense_modes(reduced.stiffness, reduced.mass)
    amplitude = np.ascontiguousarray(modes.T)
    return ModalModel(
        assembly=assembly,
        reduction=reduced.name,
        omega_squared=omega2,
        basis=reduced.shapes,
        amplitude=amplitude,
        coordinate=amplitude,
        coordinate_name=reduced.coordinate_name,
        notes=notes,
        improvement=reduced.improvement,
    )


def model_damping(
    model: ModalModel,
    damping: Damping,
    basis: LoadBasis | None = None,
    tower_top: Float[np.ndarray, "more 6"] | None = None,
) -> ModalDamping:
    """Damping of the model's modes: Rayleigh, single modes, dashpots, and drag on the structure's own motion.

    Parameters
    ----------
    model : ModalModel
        Modes of the assembled model.
    damping : Damping
        What the case says.
    basis : LoadBasis, optional
        With the damping of the nodes by drag, where the case counts it.
    tower_top : float array [more, 6], optional
        Further dashpots at the tower top, as roots of their coefficients.

    Raises
    ------
    InputError
        As :func:`~owt_structure_node.core.damping.modal_damping` and
        :func:`~owt_structure_node.core.damping.drag_vectors`.
    """
    mesh = model.assembly.mesh
    vectors = all_vectors(mesh, damping, basis, tower_top)
    if not vectors.shape[0]:
        return modal_damping(model.omega_squared, damping)
    of_functions = vectors @ model.node_basis.reshape(6 * mesh.n_nodes, -1)
    modes = of_functions if model.amplitude is None else of_functions @ model.amplitude.T
    return modal_damping(model.omega_squared, damping, modes)


def describe(model: ModalModel, damping: ModalDamping, notes: tuple[str, ...] = ()) -> ReducedDescription:
    """Names, frequencies and damping ratios, of the lowest modes where there are very many; notes of both."""
    mesh, lowest = model.assembly.mesh, slice(0, MAX_REPORTED_MODES)
    top = f"{mesh.node_name[mesh.tower_top]}.{DOF_NAME[0]}"
    decay = lowest_damped(model.omega_squared, damping, MAX_REPORTED_MODES)
    return ReducedDescription(
        model_name=mesh.structure.name,
        model_hash=mesh.structure.content_hash,
        reduction=model.reduction,
        coordinate_name=model.coordinate_name,
        frequency_hz=model.frequency_hz[lowest],
        damping_ratio=decay.ratio,
        end_name=mesh.end_name,
        tower_top_coordinate=model.coordinate_name.index(top),
        notes=(*model.notes, *notes),
        substructure_name=SUBSTRUCTURES,
    )
