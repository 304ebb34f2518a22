"""Fatigue results as plain numbers: what a summary file says and a service answers."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_model.contracts import ReducedDescription
from owt_postproc.core.stage import POINT_ANGLE_DEG, FatigueResult

__all__ = ["fatigue_summary"]


def fatigue_summary(result: FatigueResult, reduced: ReducedDescription) -> dict[str, Any]:
    """Return fatigue results as plain finite numbers, units in the keys, ready for JSON.

    Parameters
    ----------
    result : FatigueResult
        Of the record so far.
    reduced : ReducedDescription
        Names the member ends.

    Returns
    -------
    dict
        ``sn_curve``, ``scf``, ``samples``, ``duration_s``, the largest damage and total stress and where they
        are, and ``ends``: a dict per member end, its cycles those of its most damaged point.
    """
    point, damage = result.worst_point, result.damage.max(axis=1)
    ends = [
        {
            "name": name,
            "damage": float(damage[e]),
            "angle_deg": float(POINT_ANGLE_DEG[point[e]]),
            "cycles": float(result.cycles[e, point[e]]),
            "max_range_pa": float(result.max_range[e].max()),
            "total_stress_pa": float(result.total_stress[e]),
        }
        for e, name in enumerate(reduced.end_name)
    ]
    return {
        "sn_curve": result.curve.name,
        "scf": result.scf,
        "samples": result.samples,
        "duration_s": result.duration_s,
        "max_damage": float(damage.max()),
        "max_damage_end": reduced.end_name[result.worst_end],
        "max_total_stress_pa": float(result.total_stress.max()),
        "max_total_stress_end": reduced.end_name[int(np.argmax(result.total_stress))],
        "ends": ends,
    }
