"""Total stress of many sea states on one or several structures: loads once per sea, and no counting.

The sum of range times count of a rainflow count is half the total variation of the signal, exactly; so the
thesis' total stress (chapter 5) of von Mises stress needs no count.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from owt_campaign.engine import SharedModel
from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_structure_node.core import stage as response_stage
from owt_wave_node.core.stage import WaveStage

__all__ = ["BLOCK", "total_stress"]

#: Load samples worked on at a time.
BLOCK = 250


def total_stress(case: CaseConfig, models: Mapping[str, SharedModel]) -> dict[str, Float[np.ndarray, " end"]]:
    """Sum of range times count of the von Mises stress in Pa at each member end, for each structure.

    Parameters
    ----------
    case : CaseConfig
        The sea; its structure counts for nothing.
    models : mapping
        Structures of one geometry, whatever their stiffness, with their load vectors, from
        :func:`owt_campaign.engine.prepare_model`.

    Raises
    ------
    InputError
        If a model has no response of its own, since its reduction needs load vectors, or another geometry.
    ComputationError
        If a result cannot be trusted.
    """
    first = next(iter(models.values()))
    cut = case.model_copy(update={"stream": case.stream.model_copy(update={"block": BLOCK})})
    wave = WaveStage(cut, first.mesh, hydro=first.hydro)
    found = {}
    for name, model in models.items():
        if model.response is None:
            raise InputError("model", name, "has no response of its own", "Give prepare_model a load basis.")
        if not np.array_equal(model.mesh.node_position, first.mesh.node_position):
            raise InputError("model", name, "has another geometry", "Evaluate it apart.")
        wave.model_hash = model.mesh.structure.content_hash  # the loads know nothing of the stiffness
        state, last = response_stage.initial_state(model.response), None
        total = np.zeros(2 * model.mesh.n_members)
        for i in range(wave.n_blocks):
            state, out = response_stage.step(model.response, state, wave.load_block(i), None)
            stress = out.stress.von_mises
            total += np.abs(np.diff(stress, axis=0)).sum(axis=0)
            if last is not None:
                total += np.abs(stress[0] - last)
            last = stress[-1]
        found[name] = 0.5 * total
    return found
