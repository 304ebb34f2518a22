"""How hard each spot of the structure is used: what pictures and tables of a report read of a fatigue result.

A spot is a place on the surface of a member end whose stress is counted. This is the one module of the report
that knows how a :class:`FatigueResult` is laid out; results of several records add up here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from owt_model.errors import InputError
from owt_postproc.core.sn import SNCurve
from owt_postproc.core.stage import POINT_ANGLE_DEG, FatigueResult

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
    spot_scf : float array [spot]
        Stress concentration factor on the axial stress.
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
    curve : SNCurve
    """

    end_name: tuple[str, ...]
    spot_name: tuple[str, ...]
    spot_side: tuple[str, ...]
    spot_end: Int[np.ndarray, " spot"]
    spot_angle_deg: Float[np.ndarray, " spot"]
    spot_scf: Float[np.ndarray, " spot"]
    damage: Float[np.ndarray, " spot"]
    cycles: Float[np.ndarray, " spot"]
    max_range: Float[np.ndarray, " spot"]
    histogram: Float[np.ndarray, "spot bin"]
    range_edge: Float[np.ndarray, " edge"]
    total_stress: Float[np.ndarray, " end"]
    von_mises_cycles: Float[np.ndarray, " end"]
    duration_s: float
    curve: SNCurve

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

    def describe(self, spot: int) -> str:
        """Side, angle and factor of a spot in words."""
        return (
            f"{self.spot_side[spot]} at {self.spot_angle_deg[spot]:g}°, "
            f"stress concentration factor {self.spot_scf[spot]:.3g}"
        )


def usage_of(fatigue: FatigueResult, end_name: Sequence[str]) -> Usage:
    """Lay a fatigue result out by spot.

    Parameters
    ----------
    fatigue : FatigueResult
        Of one record.
    end_name : sequence of str [end]
        Names of the member ends, in the order of the result.
    """
    ends, points = fatigue.damage.shape
    angle = np.tile(POINT_ANGLE_DEG, ends)
    end = np.repeat(np.arange(ends), points)
    return Usage(
        end_name=tuple(end_name),
        spot_name=tuple(f"{end_name[e]} wall {a:g}" for e, a in zip(end.tolist(), angle, strict=True)),
        spot_side=("wall",) * (ends * points),
        spot_end=end,
        spot_angle_deg=angle,
        spot_scf=np.full(ends * points, fatigue.scf),
        damage=fatigue.damage.reshape(-1),
        cycles=fatigue.cycles.reshape(-1),
        max_range=fatigue.max_range.reshape(-1),
        histogram=fatigue.histogram.reshape(ends * points, -1),
        range_edge=fatigue.range_edge,
        total_stress=fatigue.total_stress,
        von_mises_cycles=fatigue.von_mises_cycles,
        duration_s=fatigue.duration_s,
        curve=fatigue.curve,
    )


def same_spots(first: Usage, second: Usage) -> bool:
    """Whether two records speak of the same spots, factors, S-N curve and range bins."""
    return (
        first.spot_name == second.spot_name
        and first.curve == second.curve
        and np.array_equal(first.spot_scf, second.spot_scf)
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
    return Usage(
        end_name=first.end_name,
        spot_name=first.spot_name,
        spot_side=first.spot_side,
        spot_end=first.spot_end,
        spot_angle_deg=first.spot_angle_deg,
        spot_scf=first.spot_scf,
        damage=first.damage + second.damage,
        cycles=first.cycles + second.cycles,
        max_range=np.maximum(first.max_range, second.max_range),
        histogram=first.histogram + second.histogram,
        range_edge=first.range_edge,
        total_stress=first.total_stress + second.total_stress,
        von_mises_cycles=first.von_mises_cycles + second.von_mises_cycles,
        duration_s=first.duration_s + second.duration_s,
        curve=first.curve,
    )
