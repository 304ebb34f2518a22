"""Fatigue results as plain numbers, units in the keys: of a summary file, a service, a report."""

from __future__ import annotations

from typing import Any

import numpy as np

from owt_model.contracts import ReducedDescription
from owt_postproc.core.hot_spots import SCF_NAMES
from owt_postproc.core.stage import FatigueResult

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
    spots, spot, max_range = fatigue.hot_spots, fatigue.worst_spot, fatigue.end_max_range
    ends = [
        {
            "name": name,
            "damage": float(fatigue.damage[spot[e]]),
            "hot_spot": spots.name[spot[e]],
            "joint": spots.kind[e],
            "side": spots.side[spot[e]],
            "angle_deg": float(spots.angle_deg[spot[e]]),
            "thickness_m": float(spots.thickness_m[spot[e]]),
            "scf": {
                key: float(value)
                for key, value in zip(SCF_NAMES, spots.scf[spot[e]], strict=True)
                if np.isfinite(value)
            },
            "nominal_because": spots.reason[e],
            "cycles": float(fatigue.cycles[spot[e]]),
            "max_range_pa": float(max_range[e]),
            "total_stress_pa": float(fatigue.total_stress[e]),
        }
        for e, name in enumerate(reduced.end_name)
    ]
    return {
        "sn_curve": fatigue.curve.name,
        "wall_sn_curve": fatigue.wall_curve.name,
        "scf": fatigue.scf,
        "samples": fatigue.samples,
        "duration_s": fatigue.duration_s,
        "complete": complete,
        "hot_spots": spots.n_spots,
        "notes": list(spots.notes),
        "max_damage": float(fatigue.damage.max()),
        "max_damage_end": reduced.end_name[fatigue.worst_end],
        "max_total_stress_pa": float(fatigue.total_stress.max()),
        "max_total_stress_end": reduced.end_name[int(np.argmax(fatigue.total_stress))],
        "ends": ends,
    }
