"""Damage-equivalent ranges and loads, damage over many cases, and life."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["accumulated_damage", "combined_equivalent", "equivalent_range", "life_years", "occurrences"]

SECONDS_PER_YEAR = 365.25 * 86400.0


def equivalent_range(
    ranges: Float[np.ndarray, " cycle"], counts: Float[np.ndarray, " cycle"], *, m: float, cycles: float
) -> float:
    """Range that does the same damage in `cycles` cycles, for an S-N curve of one slope m.

    (sum of range^m x count / cycles)^(1/m): the damage-equivalent stress range of stress, the
    damage-equivalent load of a load.

    Parameters
    ----------
    ranges, counts : float arrays [cycle]
        As :func:`owt_postproc.rainflow` gives them.
    m : float
        Slope of the S-N curve.
    cycles : float
        Reference number of cycles; for a reference frequency in Hz that times the duration in s.

    Returns
    -------
    float
        In the unit of the ranges; zero without cycles.

    Raises
    ------
    InputError
        If m or `cycles` is not finite and > 0.
    """
    _check_positive("m", m)
    _check_positive("cycles", cycles)
    if not ranges.size or not (largest := float(ranges.max())) > 0.0:
        return 0.0
    return float(largest * (np.sum(counts * (ranges / largest) ** m) / cycles) ** (1.0 / m))


def combined_equivalent(
    equivalent: Float[np.ndarray, "case ..."], weight: Float[np.ndarray, " case"], *, m: float
) -> Float[np.ndarray, " ..."]:
    """Equivalent range of many cases together, each with the same reference cycles.

    Parameters
    ----------
    equivalent : float array [case, ...]
        Equivalent range of each case.
    weight : float array [case]
        Share of the time that each case lasts; the sum is 1 if the reference time is that of all cases.
    m : float
        The exponent that they were made with.

    Raises
    ------
    InputError
        If m is not > 0, or a weight is negative, not finite, or missing.
    """
    _check_positive("m", m)
    return np.asarray(accumulated_damage(equivalent**m, weight) ** (1.0 / m))


def occurrences(
    probability: Float[np.ndarray, " case"], duration_s: float, *, years: float = 1.0
) -> Float[np.ndarray, " case"]:
    """How many times a record of `duration_s` happens in `years` of 365.25 days, by its case's probability.

    Raises
    ------
    InputError
        If a probability is negative or not finite, or a time not > 0.
    """
    _check_positive("duration_s", duration_s)
    _check_positive("years", years)
    _check_weights("probability", probability)
    return probability * (years * SECONDS_PER_YEAR / duration_s)


def accumulated_damage(
    damage: Float[np.ndarray, "case ..."], weight: Float[np.ndarray, " weight"]
) -> Float[np.ndarray, " ..."]:
    """Damage of every spot over all cases: the weighted sum, before any maximum over spots is taken.

    The maximum of each case may lie at another spot; a sum of maxima would be more than any spot has.

    Parameters
    ----------
    damage : float array [case, ...]
        Damage of each case.
    weight : float array [case]
        How many times each case happens, see :func:`occurrences`.

    Raises
    ------
    InputError
        If a weight is negative, not finite, or missing, or damage is negative or not finite.
    """
    _check_weights("weight", weight)
    if len(weight) != len(damage):
        raise InputError("weight", f"{len(weight)} values", f"must be one a case, {len(damage)}", "Add them.")
    if not (np.isfinite(damage) & (damage >= 0.0)).all():
        raise InputError(
            "damage", "NaN, inf or negative", "must be finite and >= 0", "Leave out failed cases."
        )
    return np.asarray(np.tensordot(weight, damage, axes=1))


def life_years(damage_per_year: Any, *, design_fatigue_factor: float = 1.0) -> Any:
    """Years until damage times the design fatigue factor reaches 1; infinite without damage.

    Parameters
    ----------
    damage_per_year : float or float array
        Palmgren-Miner sum of a year.
    design_fatigue_factor : float
        Factor on damage, 1 to 3 or more by how a spot can be inspected and what its failure means.

    Raises
    ------
    InputError
        If damage is negative or not finite, or the factor below 1.
    """
    damage = np.asarray(damage_per_year, dtype=np.float64)
    if not (np.isfinite(damage) & (damage >= 0.0)).all():
        raise InputError("damage_per_year", damage_per_year, "must be finite and >= 0", "Check the damage.")
    if not (np.isfinite(design_fatigue_factor) and design_fatigue_factor >= 1.0):
        raise InputError(
            "design_fatigue_factor", design_fatigue_factor, "must be at least 1", "See the design standard."
        )
    with np.errstate(divide="ignore"):
        life = 1.0 / (design_fatigue_factor * damage)
    return life if life.ndim else float(life)


def _check_positive(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(name, value, "must be finite and > 0", "Give a positive number.")


def _check_weights(name: str, values: Float[np.ndarray, " case"]) -> None:
    if not (np.isfinite(values) & (values >= 0.0)).all():
        raise InputError(name, values, "must be finite and >= 0", "Check the occurrence table.")
