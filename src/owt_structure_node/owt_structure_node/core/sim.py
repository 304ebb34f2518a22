"""Static improvement (SIM): the static response of what a basis leaves out, added in recovery.

OpenFAST's answer to the need that augmentation vectors meet (SubDyn theory, "Static-Improvement Method"):
the motion inside the jacket is

    u_i = Psi u_b + Phi eta + (K_ii^-1 - Phi Omega^-2 Phi') f_i

where Phi are all functions that the basis keeps inside, modes and augmentation vectors. The added motion is
K-orthogonal to all of the basis, so that its potential energy adds up; its velocity is neglected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_structure_node.core.assembly import Assembly
from owt_structure_node.core.modes import Factor
from owt_structure_node.core.recovery import end_force_map

__all__ = ["ImprovementMap", "StaticImprovement"]


@dataclass(frozen=True)
class ImprovementMap:
    """Static improvement as a linear function of the nodal loads of a stream.

    Attributes
    ----------
    compliance : float array [loaded*6, loaded*6]
        Displacement of the loaded nodes per load, what the basis gives left out.
    end_force : float array [loaded*6, end*6]
        K_e u_e at the member ends, in element axes, per load.
    """

    compliance: Float[np.ndarray, "load load"]
    end_force: Float[np.ndarray, "load component"]

    def energy(self, load: Float[np.ndarray, "sample load"], substeps: int) -> Float[np.ndarray, " row"]:
        """Potential energy in J at the first sample and `substeps` times after each, load linear between."""
        moved = load @ self.compliance
        own = 0.5 * np.einsum("sl,sl->s", load, moved)
        cross = 0.5 * np.einsum("sl,sl->s", load[:-1], moved[1:])
        part = np.arange(1, substeps + 1) / substeps
        before, after = (1.0 - part) ** 2, part**2
        between = own[:-1, None] * before + 2.0 * cross[:, None] * part * (1.0 - part) + own[1:, None] * after
        return np.concatenate([own[:1], between.reshape(-1)])

    def forces(self, load: Float[np.ndarray, "sample load"]) -> Float[np.ndarray, "sample element 12"]:
        """K_e u_e at both ends of each member, laid out as fixed-end forces are."""
        return np.ascontiguousarray(load @ self.end_force).reshape(len(load), -1, 12)

    @property
    def columns(self) -> Int[np.ndarray, "end 2"]:
        """Where each member end stands in :meth:`forces`: member, and first of six components."""
        end = np.arange(self.end_force.shape[1] // 6, dtype=np.int64)
        return np.stack([end // 2, 6 * (end % 2)], axis=1)


@dataclass(frozen=True)
class StaticImprovement:
    """What the static response inside the jacket needs.

    Attributes
    ----------
    assembly : Assembly
    factor : Factor
        Of K_ii.
    functions : float array [internal, function]
        What the basis keeps inside, each divided by its own sqrt(function' K function).
    """

    assembly: Assembly
    factor: Factor
    functions: Float[np.ndarray, "internal function"]

    def residual(self, load: Float[np.ndarray, "internal case"]) -> Float[np.ndarray, "internal case"]:
        """Static displacement inside the jacket, interface held, less what the basis gives."""
        return np.asarray(self.factor.solve(load) - self.functions @ (self.functions.T @ load))

    def map(self, node: Int[np.ndarray, " loaded"]) -> ImprovementMap:
        """Improvement per nodal load at the nodes `node`."""
        assembly = self.assembly
        rows = (6 * node[:, None] + np.arange(6)).reshape(-1)
        to_dof = assembly.expansion[rows].T.tocsr()[: assembly.internal].toarray()
        inside = self.residual(to_dof)
        compliance = to_dof.T @ inside
        shapes = np.zeros((assembly.mesh.n_dof, len(rows)))
        shapes[: assembly.internal] = inside
        force = end_force_map(assembly, shapes)
        return ImprovementMap(
            compliance=0.5 * (compliance + compliance.T), end_force=force.reshape(len(rows), -1)
        )
