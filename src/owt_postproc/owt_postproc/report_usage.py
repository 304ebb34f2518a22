"""How hard each spot of the structure is used: what pictures and tables of a report read of a fatigue result.

A spot is a place on the surface of a member end whose stress is counted. This is the one module of the report
that knows how a :class:`FatigueResult` is laid out; results of several records add up here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from owt_model.errors import InputError
from owt_postproc.core.hot_spots import SCF_NAMES
from owt_postproc.core.sn_curve import SNCurve
from owt_postproc.core.stage import FatigueResult

__all__ = ["Usage", "add_up", "same_spots", "usage_of"]


@dataclass(frozen=True)
class Usage:
    """Results by spot and by member end.

    Attributes
    ----------
    end_name : tuple of str [end]
        ``member:joint``.
    spot_name, spot_side : tuples of str [spot]
        Name, and which wall it lies on.
    spot_end : int array [spot]
        Member end that the spot belongs to.
    spot_angle_deg : float array [spot]
        Angle round the section.
    spot_scf : float array [spot, 8]
        Stress concentration factors by ``SCF_NAMES``; NaN where there is none.
    wall_scf : float
        Stress concentration factor of walls, away from tubular connections.
    end_kind, end_reason : tuples of str [end]
        Class of the joint that the end makes, or why it has no tubular connection; empty otherwise.
    damage, cycles, max_range : float arrays [spot]
        Palmgren-Miner sum, cycles, and largest range in Pa of the normal stress, factor included.
    histogram : float array [spot, bin]
        Cycles per range bin.
    range_edge : float array [bin - 1]
        Inner edges of the range bins in Pa; the first and the last bin are open.
    total_stress, von_mises_cycles : float arrays [end]
        Sum of range x count in Pa, and cycles, of the nominal von Mises stress.
    duration_s : float
        Time that was counted.
    curve, wall_curve : SNCurve
        Of the hot spots of tubular joints, and of walls.
    """

    end_name: tuple[str, ...]
    spot_name: tuple[str, ...]
    spot_side: tuple[str, ...]
    spot_end: Int[np.ndarray, " spot"]
    spot_angle_deg: Float[np.ndarray, " spot"]
    spot_scf: Float[np.ndarray, "spot 8"]
    wall_scf: float
    end_kind: tuple[str, ...]
    end_reason: tuple[str, ...]
    damage: Float[np.ndarray, " spot"]
    cycles: Float[np.ndarray, " spot"]
    max_range: Float[np.ndarray, " spot"]
    histogram: Float[np.ndarray, "spot bin"]
    range_edge: Float[np.ndarray, " edge"]
    total_stress: Float[np.ndarray, " end"]
    von_mises_cycles: Float[np.ndarray, " end"]
    duration_s: float
    curve: SNCurve
    wall_curve: SNCurve

    @cached_property
    def worst_spot(self) -> Int[np.ndarray, " end"]:
        """Spot of largest damage of each end; the first where none is damaged."""
        order = np.lexsort((np.arange(len(self.damage))[::-1], self.damage))
        worst = np.empty(len(self.end_name), dtype=np.int64)
        worst[self.spot_end[order]] = order  # the last one written stays
        return worst

    @property
    def end_damage(self) -> Float[np.ndarray, " end"]:
        """Largest damage of each end."""
        return np.asarray(self.damage[self.worst_spot])

    @property
    def end_max_range(self) -> Float[np.ndarray, " end"]:
        """Largest range in Pa among the spots of each end."""
        largest = np.zeros(len(self.end_name))
        np.maximum.at(largest, self.spot_end, self.max_range)
        return largest

    @property
    def most_used(self) -> int:
        """Spot of largest damage of all."""
        return int(self.worst_spot[np.argmax(self.end_damage)])

    @property
    def spot_factor(self) -> Float[np.ndarray, " spot"]:
        """Largest stress concentration factor of each spot's connection and side, one brace loaded."""
        four = self.spot_scf[:, :4]
        there = np.isfinite(four).any(axis=1)
        largest = np.where(np.isfinite(four), four, -np.inf).max(axis=1)
        return np.where(there, largest, self.wall_scf)

    def describe(self, spot: int) -> str:
        """Joint, side, angle and factors of a spot in words."""
        side, angle = self.spot_side[spot], f"{self.spot_angle_deg[spot]:g}°"
        kind = self.end_kind[int(self.spot_end[spot])]
        factors = [
            f"{name.replace('_', ' ')} {value:.2f}"
            for name, value in zip(SCF_NAMES[:4], self.spot_scf[spot], strict=False)
            if np.isfinite(value)
        ]
        if not factors:
            return f"{side} at {angle}, stress concentration factor {self.wall_scf:g}"
        return f"{side} of the {kind} joint at {angle}, stress concentration factors: {', '.join(factors)}"


def usage_of(fatigue: FatigueResult, end_name: Sequence[str]) -> Usage:
    """Lay a fatigue result out by spot.

    Parameters
    ----------
    fatigue : FatigueResult
        Of one record.
    end_name : sequence of str [end]
        Names of the member ends, in the order of the result.
    """
    spots = fatigue.hot_spots
    return Usage(
        end_name=tuple(end_name),
        spot_name=spots.name,
        spot_side=spots.side,
        spot_end=spots.end,
        spot_angle_deg=spots.angle_deg,
        spot_scf=spots.scf,
        wall_scf=fatigue.scf,
        end_kind=spots.kind,
        end_reason=spots.reason,
        damage=fatigue.damage,
        cycles=fatigue.cycles,
        max_range=fatigue.max_range,
        histogram=fatigue.histogram,
        range_edge=fatigue.range_edge,
        total_stress=fatigue.total_stress,
        von_mises_cycles=fatigue.von_mises_cycles,
        duration_s=fatigue.duration_s,
        curve=fatigue.curve,
        wall_curve=fatigue.wall_curve,
    )


def same_spots(first: Usage, second: Usage) -> bool:
    """Whether two records speak of the same spots, factors, S-N curve and range bins."""
    return (
        first.spot_name == second.spot_name
        and (first.curve, first.wall_curve) == (second.curve, second.wall_curve)
        and first.wall_scf == second.wall_scf
        and np.array_equal(first.spot_scf, second.spot_scf, equal_nan=True)
        and np.array_equal(first.range_edge, second.range_edge)
    )


def add_up(first: Usage, second: Usage) -> Usage:
    """Usage after both records: damage and counts of each spot added, the larger of the largest ranges.

    The most used spot is to be looked for in the sum: it need not be that of either record.

    Raises
    ------
    InputError
        If the two do not speak of the same spots, S-N curve and range bins.
    """
    if not same_spots(first, second):
        raise InputError(
            "records",
            f"{first.curve.name} and {second.curve.name}",
            "have other spots, factors or S-N curves, so that their damage does not add up",
            "Add up records of one structure and one set of fatigue options.",
        )
    return replace(
        first,
        damage=first.damage + second.damage,
        cycles=first.cycles + second.cycles,
        max_range=np.maximum(first.max_range, second.max_range),
        histogram=first.histogram + second.histogram,
        total_stress=first.total_stress + second.total_stress,
        von_mises_cycles=first.von_mises_cycles + second.von_mises_cycles,
        duration_s=first.duration_s + second.duration_s,
    )
