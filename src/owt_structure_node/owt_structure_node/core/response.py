"""The assembled reduced model in its own modes: what the time integration and the recovery work with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.contracts import LoadBasis, ReducedDescription
from owt_model.errors import InputError
from owt_model.mesh import Mesh
from owt_structure_node.core.assembly import DOF_NAME, Assembly, assemble
from owt_structure_node.core.auto import Target, chosen_reduction
from owt_structure_node.core.modes import dense_modes
from owt_structure_node.core.sim import StaticImprovement

__all__ = ["MAX_REPORTED_MODES", "ModalModel", "build_modal_model", "describe", "drag_rate", "modal_damping"]

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


def build_modal_model(
    mesh: Mesh,
    reduction: str,
    basis: LoadBasis | None = None,
    target: Target | None = None,
    *,
    jacket_stiffness_factor: float = 1.0,
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
    jacket_stiffness_factor : float
        Factor on the stiffness of the members.

    Raises
    ------
    InputError, ComputationError
        As :func:`owt_structure_node.core.auto.chosen_reduction` and the eigenvalue solution.
    """
    assembly = assemble(mesh, jacket_stiffness_factor=jacket_stiffness_factor)
    if reduction == "full":
        omega2, shapes = dense_modes(assembly.stiffness.toarray(), assembly.mass.toarray())
        nodes = [mesh.transition_piece, *mesh.tower_node]
        names = [f"{mesh.node_name[node]}.{direction}" for node in nodes for direction in DOF_NAME]
        coordinate = np.ascontiguousarray(shapes[mesh.node_dof[nodes].reshape(-1)].T)
        return ModalModel(assembly, reduction, omega2, shapes, None, coordinate, tuple(names))
    reduced, notes = chosen_reduction(
        assembly, reduction, basis, target, jacket_stiffness_factor=jacket_stiffness_factor
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


def modal_damping(
    omega_squared: Float[np.ndarray, " mode"], alpha: float, beta: float
) -> tuple[Float[np.ndarray, " mode"], Float[np.ndarray, " mode"]]:
    """Rayleigh damping of each mode: 2 zeta omega = alpha + beta omega^2 in 1/s, and the ratio zeta."""
    rate = alpha + beta * omega_squared
    return rate, np.asarray(rate / (2.0 * np.sqrt(omega_squared)))


def drag_rate(model: ModalModel, basis: LoadBasis | None) -> Float[np.ndarray, " mode"]:
    """What the drag on the structure's own motion adds to 2 zeta omega of each mode, in 1/s.

    The diagonal of Phi' C Phi, C the damping of the load basis: what couples modes is neglected, small as it
    is against the distance of their frequencies for light damping. Zero without such damping.

    Raises
    ------
    InputError
        If the damping does not fit the nodes of the basis or of the mesh.
    """
    if basis is None or not len(basis.damping):
        return np.zeros(len(model.omega_squared))
    n_nodes = model.assembly.mesh.n_nodes
    if len(basis.damping) != len(basis.node) or basis.node.max() >= n_nodes:
        raise InputError(
            "load_basis.damping",
            len(basis.damping),
            f"must be one matrix for each of {len(basis.node)} nodes of the mesh",
            "Give the damping of the loaded nodes.",
        )
    motion = model.node_basis[basis.node, :3]
    if model.amplitude is not None:
        motion = motion @ model.amplitude.T
    return np.asarray(np.einsum("nam,nab,nbm->m", motion, basis.damping, motion, optimize=True))


def describe(
    model: ModalModel, alpha: float, beta: float, drag: Float[np.ndarray, " mode"] | float = 0.0
) -> ReducedDescription:
    """Names, frequencies and damping ratios, of the lowest modes where there are very many.

    `drag` is what :func:`drag_rate` gives.
    """
    mesh, lowest = model.assembly.mesh, slice(0, MAX_REPORTED_MODES)
    top = f"{mesh.node_name[mesh.tower_top]}.{DOF_NAME[0]}"
    _, ratio = modal_damping(model.omega_squared, alpha, beta)
    return ReducedDescription(
        model_name=mesh.structure.name,
        model_hash=mesh.structure.content_hash,
        reduction=model.reduction,
        coordinate_name=model.coordinate_name,
        frequency_hz=model.frequency_hz[lowest],
        damping_ratio=(ratio + drag / (2.0 * np.sqrt(model.omega_squared)))[lowest],
        end_name=mesh.end_name,
        tower_top_coordinate=model.coordinate_name.index(top),
        notes=model.notes,
    )
