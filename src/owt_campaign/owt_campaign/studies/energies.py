"""Energies of the response without its stresses: what studies that only ask for them need of a model.

Modes are integrated exactly for loads that are linear between their samples, at the step of the loads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_model.structure_config import Damping
from owt_structure_node.core.motion import Motion, Oscillators, integrate_from, static_state
from owt_structure_node.core.response import ModalModel, model_damping

__all__ = ["EnergyModel"]

#: Load samples worked on at a time.
CHUNK = 1000


@dataclass(frozen=True)
class EnergyModel:
    """A structure in its modes, and how loads on some of its nodes act on them.

    Attributes
    ----------
    projection : float array [load, mode]
        Modal load per unit of each component of the nodal loads.
    oscillators : Oscillators
    coordinate : float array [mode, coordinate]
        Generalised coordinates per unit amplitude of each mode.
    coordinate_name : tuple of str
    """

    projection: Float[np.ndarray, "load mode"]
    oscillators: Oscillators
    coordinate: Float[np.ndarray, "mode coordinate"]
    coordinate_name: tuple[str, ...]

    @classmethod
    def of(
        cls, model: ModalModel, node: Int[np.ndarray, " loaded"], damping: Damping, dt: float
    ) -> EnergyModel:
        """Take a decoupled model.

        Parameters
        ----------
        model : ModalModel
            Modes of the assembled structure; without static improvement.
        node : int array [loaded]
            The loaded nodes.
        damping : Damping
            Of the structure.
        dt : float
            Step of the loads in s.
        """
        found = model_damping(model, damping)
        functions = model.node_basis[node].reshape(6 * len(node), -1)
        projection = functions if model.amplitude is None else functions @ model.amplitude.T
        oscillators = Oscillators(model.omega_squared, found.rate, dt, 1, "exact", found.dashpots)
        return cls(np.ascontiguousarray(projection), oscillators, model.coordinate, model.coordinate_name)

    def motion(self, nodal: Float[np.ndarray, "time load"]) -> Motion:
        """Modal motion at the samples of a load history, from rest under its first sample."""
        state = static_state(self.oscillators, nodal[0] @ self.projection)
        return integrate_from(self.oscillators, state, nodal[1:] @ self.projection)[1]

    def potential(self, nodal: Float[np.ndarray, "time load"]) -> Float[np.ndarray, " time"]:
        """Potential energy in J at the samples of a load history; a piece of the motion is held at a time."""
        state = static_state(self.oscillators, nodal[0] @ self.projection)
        half = 0.5 * self.oscillators.stiffness
        energy = np.empty(len(nodal))
        energy[0] = state.displacement**2 @ half
        for i in range(1, len(nodal), CHUNK):
            rows = slice(i, min(i + CHUNK, len(nodal)))
            state, motion = integrate_from(self.oscillators, state, nodal[rows] @ self.projection)
            energy[rows] = motion.displacement[1:] ** 2 @ half
        return energy
