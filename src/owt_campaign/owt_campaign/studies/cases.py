"""Cases of the studies: the thesis' sea states on its turbine, with named wave models, cut-offs and seeds."""

from __future__ import annotations

from typing import Any

from owt_model.config import CaseConfig, Time, Wave, parse_case
from owt_model.sensitivity import sensitivity_model
from owt_model.structure_config import StructureConfig

__all__ = ["CUTOFFS", "LINEAR", "MODEL", "SECOND_ORDER", "SEEDS", "WAVE_MODELS", "study_case"]

MODEL = "oc4-thesis"
#: Seeds of every sea state, as many as the thesis has (its own are not published).
SEEDS = (1, 2, 3)
#: Kinematics above still water of each wave model. The thesis expands the first order of its second-order
#: model (eq. 2.19) and does not say what its linear model does.
WAVE_MODELS: dict[str, Wave] = {
    "linear, constant": Wave(order=1, stretching="constant"),
    "linear, Wheeler": Wave(order=1, stretching="wheeler"),
    "linear, Taylor": Wave(order=1, stretching="taylor"),
    "second order": Wave(order=2, stretching="taylor"),
}
#: The linear model of a study that does not compare all three: constant extrapolation is what thesis 2.6
#: calls "a linear method", and what 4.2.4 gives its linear waves; Taylor expansion is that of second order.
LINEAR, SECOND_ORDER = "linear, constant", "second order"
#: Highest component: thesis table 4.3, and DNV's advice for second order.
CUTOFFS: dict[str, dict[str, Any]] = {
    "4 omega_p": {"cutoff": "over_peak", "cutoff_over_peak": 4.0},
    "sqrt(2g/Hs)": {"cutoff": "steepness"},
}


def study_case(
    hs_m: float,
    tp_s: float,
    *,
    seed: int = 1,
    direction_deg: float = 210.0,
    wave: str = SECOND_ORDER,
    cutoff: str = "4 omega_p",
    structure: str = "reference",
    reduction: str = "CB10M10",
    duration_s: float = 600.0,
    **changes: Any,
) -> CaseConfig:
    """One sea state on the thesis' turbine; what is not named here is that of thesis table 4.3.

    Parameters
    ----------
    hs_m, tp_s : float
        Significant wave height in m and peak period in s.
    seed : int
        Of the random phases.
    direction_deg : float
        Direction the waves travel to, from +x towards +y.
    wave : str
        One of :data:`WAVE_MODELS`.
    cutoff : str
        One of :data:`CUTOFFS`.
    structure : str
        One of :data:`~owt_model.sensitivity.SENSITIVITY_MODELS`.
    reduction : str
        As in the case file.
    duration_s : float
        Length of the record in s.
    **changes
        More keys of the case, as in the case file.

    Raises
    ------
    InputError
        If the case is refused.
    """
    sea = {"hs_m": hs_m, "tp_s": tp_s, "direction_deg": direction_deg, "seed": seed, **CUTOFFS[cutoff]}
    base = StructureConfig(model=MODEL, reduction=reduction)
    time = Time()
    data = {
        "sea_state": sea,
        "wave": WAVE_MODELS[wave].model_dump(),
        "time": {"dt_s": time.dt_s, "n": round(duration_s / time.dt_s)},
        "structure": sensitivity_model(structure, base).model_dump(mode="json"),
    }
    return parse_case({**data, **changes})
