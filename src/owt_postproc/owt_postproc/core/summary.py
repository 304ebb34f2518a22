"""Fatigue results as plain numbers, units in the keys: of a summary file, a service, a report."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_model.contracts import ReducedDescription
from owt_postproc.core.stage import POINT_ANGLE_DEG, FatigueResult

__all__ = ["fatigue_summary"]


def fatigue_summary(fatigue: FatigueResult, reduced: ReducedDescription, *, complete: bool) -> dict[str, Any]:
    """Return the results of all member ends, ready for JSON.

    Parameters
    ----------
    fatigue : FatigueResult
        What was counted.
    reduced : ReducedDescription
        Names of the ends.
    complete : bool
        Whether the stress reaches the end of the record.
    """
    point, damage = fatigue.worst_point, fatigue.damage.max(axis=1)
    ends = [
        {
            "name": name,
            "damage": float(damage[e]),
            "angle_deg": float(POINT_ANGLE_DEG[point[e]]),
            "cycles": float(fatigue.cycles[e, point[e]]),
            "max_range_pa": float(fatigue.max_range[e].max()),
            "total_stress_pa": float(fatigue.total_stress[e]),
        }
        for e, name in enumerate(reduced.end_name)
    ]
    return {
        "sn_curve": fatigue.curve.name,
        "scf": fatigue.scf,
        "samples": fatigue.samples,
        "duration_s": fatigue.duration_s,
        "complete": complete,
        "max_damage": float(damage.max()),
        "max_damage_end": reduced.end_name[fatigue.worst_end],
        "max_total_stress_pa": float(fatigue.total_stress.max()),
        "max_total_stress_end": reduced.end_name[int(np.argmax(fatigue.total_stress))],
        "ends": ends,
    }
