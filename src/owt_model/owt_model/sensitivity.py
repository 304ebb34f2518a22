"""The thesis' models of chapter 5.3: the reference, more damping, a softer jacket."""

from __future__ import annotations

from typing import Any

from owt_model.errors import InputError
from owt_model.structure_config import Damping, StructureConfig

__all__ = ["SENSITIVITY_MODELS", "sensitivity_model"]

#: What each model changes in the structure of a case.
SENSITIVITY_MODELS: dict[str, dict[str, Any]] = {
    "reference": {},
    # A tower-top dashpot gives table B.3's pattern; the thesis does not say what it did.
    "damping": {"damping": Damping(tower_top=(6.1e4, 6.1e4, 0.0, 0.0, 0.0, 0.0))},
    # The other reading: 30 % on the first two modes alone.
    "damping-modal": {"damping": Damping(modes=((1, 30.0), (2, 30.0)))},
    "frequency": {"jacket_stiffness_factor": 0.37, "damping": Damping(alpha=0.021, beta=0.0024)},
}


def sensitivity_model(name: str, base: StructureConfig | None = None) -> StructureConfig:
    """Structure of a case as one of the models has it.

    Parameters
    ----------
    name : str
        One of :data:`SENSITIVITY_MODELS`.
    base : StructureConfig, optional
        What stays as it is: model, reduction, integration; ``oc4-thesis`` where left out.

    Raises
    ------
    InputError
        If there is no such model.
    """
    if name not in SENSITIVITY_MODELS:
        raise InputError(
            "sensitivity", name, "is no such model", f"Choose one of {', '.join(SENSITIVITY_MODELS)}."
        )
    base = StructureConfig(model="oc4-thesis") if base is None else base
    return base.model_copy(update=SENSITIVITY_MODELS[name])
