"""What runs of chapter 5 add up to over the load-case table: totals per member, ratios, their spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, occurrence
from owt_campaign.studies.stress_runs import Sea, StressRecord, StressRuns
from owt_model.mesh import Mesh

__all__ = ["Members", "TableRuns", "run_table"]

#: Total stress of a member, of the largest one, below which it is not looked at: those inside the transition
#: piece, which is rigid.
RELEVANT = 1e-3


@dataclass(frozen=True)
class Members:
    """Members of the jacket as the figures order them.

    Attributes
    ----------
    name : tuple of str
    level : float array [member]
        z of the middle in m.
    leg, pile : bool arrays [member]
        Legs, and the grouted piles below them; the rest are braces.
    """

    name: tuple[str, ...]
    level: Float[np.ndarray, " member"]
    leg: np.ndarray
    pile: np.ndarray

    @classmethod
    def of(cls, mesh: Mesh) -> Members:
        """Take those of a mesh."""
        diameter = mesh.element_diameter[mesh.member_element[:, 0]]
        level = mesh.node_position[mesh.member_node, 2].mean(axis=1)
        return cls(mesh.member_name, level, diameter == 1.2, diameter > 1.5)

    def kind(self, m: int) -> str:
        """What a member is, in words."""
        what = "leg" if self.leg[m] else "pile" if self.pile[m] else "brace"
        return f"{what} {self.name[m]} at z = {self.level[m]:.0f} m"


@dataclass(frozen=True)
class TableRuns:
    """Records of one structure by seed, wave model and cell."""

    records: Mapping[tuple[int, str], Mapping[Cell, StressRecord]]

    def seeds(self, wave: str = SECOND_ORDER) -> list[int]:
        """Seeds that there are of a wave model."""
        return sorted(seed for seed, name in self.records if name == wave)

    def cells(self, seed: int, wave: str = SECOND_ORDER) -> list[Cell]:
        """Cells that there are of a seed."""
        return list(self.records[seed, wave])

    def total(
        self, wave: str, seed: int, *, weights: str = "assumed", part: str = "total_stress"
    ) -> Float[np.ndarray, " end"]:
        """Sum over the cells of a seed, each by its probability."""
        some = self.records[seed, wave]
        share = occurrence(list(some), weights)
        return np.asarray(sum(p * getattr(r, part) for p, r in zip(share, some.values(), strict=True)))

    def mean_total(self, wave: str, **options: str) -> Float[np.ndarray, " end"]:
        """Mean of :meth:`total` over the seeds."""
        return np.mean([self.total(wave, seed, **options) for seed in self.seeds(wave)], axis=0)

    def ratio(
        self, seed: int | None = None, linear: str = LINEAR, **options: str
    ) -> Float[np.ndarray, " member"]:
        """Second order over linear of the total stress of every member; of all seeds where none is named.

        Of both ends of a member the larger total counts. NaN for members without stress.
        """
        one, two = (
            by_member(self.mean_total(w, **options) if seed is None else self.total(w, seed, **options))
            for w in (linear, SECOND_ORDER)
        )
        seen = two > RELEVANT * two.max()
        return np.where(seen, two, np.nan) / np.where(seen, one, 1.0)


def by_member(total: Float[np.ndarray, " end"]) -> Float[np.ndarray, " member"]:
    """Larger one of the two ends of each member."""
    return np.asarray(total.reshape(-1, 2).max(axis=1))


def run_table(
    runs: StressRuns,
    plan: Sequence[tuple[int, str, Sequence[Cell], Sequence[str]]],
    progress: Progress,
) -> dict[str, TableRuns]:
    """Run parts of the load-case table.

    Parameters
    ----------
    runs : StressRuns
        What the runs share.
    plan : sequence of tuples
        Seed, wave model, cells and structures of each part.
    progress : callable
        Called with the runs done and those in all.

    Returns
    -------
    dict of TableRuns
        By structure.
    """
    found: dict[str, dict[tuple[int, str], dict[Cell, StressRecord]]] = {}
    done, total = 0, sum(len(cells) for _, _, cells, _ in plan)
    for seed, wave, cells, structures in plan:
        for cell in cells:
            for name, record in runs.records(Sea(cell, seed, wave), structures).items():
                found.setdefault(name, {}).setdefault((seed, wave), {})[cell] = record
            done += 1
            progress(done, total)
    return {name: TableRuns(records) for name, records in found.items()}
