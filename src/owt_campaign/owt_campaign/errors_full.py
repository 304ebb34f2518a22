"""Errors of a reduced model against the unreduced one, for the same sea."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from owt_campaign.engine import CaseOutcome

__all__ = ["ErrorsAgainstFull", "errors_against_full"]

#: Results below this share of the largest one count with that share: their own size says nothing.
FLOOR = 1e-6


@dataclass(frozen=True)
class ErrorsAgainstFull:
    """Relative errors, (reduced - full) / full.

    Attributes
    ----------
    damage_error : float array [spot]
    total_stress_error : float array [end]
    potential_mean_error, kinetic_mean_error, potential_std_error, kinetic_std_error : float arrays [part]
    """

    damage_error: Float[np.ndarray, " spot"]
    total_stress_error: Float[np.ndarray, " end"]
    potential_mean_error: Float[np.ndarray, " part"]
    kinetic_mean_error: Float[np.ndarray, " part"]
    potential_std_error: Float[np.ndarray, " part"]
    kinetic_std_error: Float[np.ndarray, " part"]

    #: Dimension and meaning of each.
    MEANING: ClassVar[Mapping[str, tuple[str, str]]] = {
        "damage_error": ("spot", "error of the damage against the unreduced model"),
        "total_stress_error": ("end", "error of the total stress against the unreduced model"),
        "potential_mean_error": ("part", "error of the mean potential energy against the unreduced model"),
        "kinetic_mean_error": ("part", "error of the mean kinetic energy against the unreduced model"),
        "potential_std_error": ("part", "error of the deviation of the potential energy"),
        "kinetic_std_error": ("part", "error of the deviation of the kinetic energy"),
    }


def errors_against_full(reduced: CaseOutcome, full: CaseOutcome) -> ErrorsAgainstFull:
    """Errors of `reduced`."""
    ours, theirs = reduced.energy, full.energy
    return ErrorsAgainstFull(
        damage_error=_relative(reduced.fatigue.damage, full.fatigue.damage),
        total_stress_error=_relative(reduced.fatigue.total_stress, full.fatigue.total_stress),
        potential_mean_error=_relative(ours.potential_mean, theirs.potential_mean),
        kinetic_mean_error=_relative(ours.kinetic_mean, theirs.kinetic_mean),
        potential_std_error=_relative(ours.potential_std, theirs.potential_std),
        kinetic_std_error=_relative(ours.kinetic_std, theirs.kinetic_std),
    )


def _relative(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    scale = np.maximum(np.abs(wanted), FLOOR * np.abs(wanted).max())
    return np.asarray(np.divide(found - wanted, scale, out=np.zeros_like(found), where=scale > 0.0))
