"""What runs of chapter 5 add up to over the load-case table: totals per member, ratios, their spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.dask_pool import DaskPool, InProcess, Pool, WorkerLostError
from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, occurrence
from owt_campaign.studies.stress_runs import Sea, StressRecord, compute_run
from owt_model.mesh import Mesh

__all__ = ["Members", "Part", "TableRuns", "run_table"]

#: Seed, wave model, cells and structures of runs.
Part = tuple[int, str, Sequence[Cell], Sequence[str]]

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

    @property
    def linears(self) -> list[str]:
        """Linear models that there are."""
        return list(dict.fromkeys(wave for _, wave in self.records if wave != SECOND_ORDER))

    @property
    def counts(self) -> dict[str, dict[int, int]]:
        """Number of sea states of each seed, by wave model."""
        found: dict[str, dict[int, int]] = {}
        for (seed, wave), cells in self.records.items():
            found.setdefault(wave, {})[seed] = len(cells)
        return found

    @property
    def described(self) -> str:
        """The same in words."""
        parts = []
        for wave, counts in self.counts.items():
            for count in dict.fromkeys(counts.values()):
                seeds = ", ".join(str(seed) for seed, own in counts.items() if own == count)
                parts.append(f"{wave}: {count} sea states with seeds {seeds}")
        return "; ".join(parts)

    def total(
        self,
        wave: str,
        seed: int | None = None,
        *,
        weights: str = "assumed",
        part: str = "total_stress",
        like: str | None = None,
    ) -> Float[np.ndarray, ...]:
        """Sum over the cells, each by its probability.

        Parameters
        ----------
        wave : str
            Wave model.
        seed : int, optional
            Of the records; of each cell the mean over its seeds where left out.
        weights : str
            As :func:`~owt_campaign.studies.sea_table.occurrence` takes them.
        part : str
            What of the records is summed.
        like : str, optional
            Another wave model: cells and seeds that this one lacks are left out.
        """
        seeds = self.seeds(wave) if seed is None else [seed]
        values: dict[Cell, list[np.ndarray]] = {}
        for number in seeds:
            other = self.records.get((number, wave if like is None else like), {})
            for cell, record in self.records[number, wave].items():
                if cell in other:
                    values.setdefault(cell, []).append(getattr(record, part))
        share = occurrence(list(values), weights)
        return np.asarray(sum(p * np.mean(of, axis=0) for p, of in zip(share, values.values(), strict=True)))

    def ratio(
        self, seed: int | None = None, linear: str = LINEAR, weights: str = "assumed"
    ) -> Float[np.ndarray, " member"]:
        """Second order over linear of the total stress of every member; of all seeds where none is named.

        Of both ends of a member the larger total counts. NaN for members without stress.
        """
        one = by_member(self.total(linear, seed, weights=weights, like=SECOND_ORDER))
        two = by_member(self.total(SECOND_ORDER, seed, weights=weights, like=linear))
        seen = two > RELEVANT * two.max()
        return np.where(seen, two, np.nan) / np.where(seen, one, 1.0)


def by_member(total: Float[np.ndarray, " end"]) -> Float[np.ndarray, " member"]:
    """Larger one of the two ends of each member."""
    return np.asarray(total.reshape(-1, 2).max(axis=1))


def run_table(
    samples: int, plan: Sequence[Part], progress: Progress, *, workers: int = 0, shared_phases: bool = False
) -> dict[str, TableRuns]:
    """Run parts of the load-case table.

    Parameters
    ----------
    samples : int
        Length of the records in load steps.
    plan : sequence of tuples
        Seed, wave model, cells and structures of each part.
    progress : callable
        Called with the runs done and those in all.
    workers : int
        Processes to use; 0 computes in this one.
    shared_phases : bool
        Give all sea states the phases of their seed.

    Returns
    -------
    dict of TableRuns
        By structure.

    Raises
    ------
    WorkerLostError
        If the workers that ran a sea died.
    """
    seas = [
        (Sea(cell, seed, wave, shared_phases=shared_phases), names)
        for seed, wave, cells, names in plan
        for cell in cells
    ]
    computed: dict[Sea, dict[str, StressRecord]] = {}
    pool: Pool = DaskPool(workers) if workers else InProcess()
    with pool:
        for done in pool.run((sea, compute_run, (samples, sea, tuple(names))) for sea, names in seas):
            if isinstance(done.result, WorkerLostError):
                raise done.result
            computed[done.job] = done.result
            progress(len(computed), len(seas))
    found: dict[str, dict[tuple[int, str], dict[Cell, StressRecord]]] = {}
    for sea, names in seas:  # in the order of the plan, whoever was first: sums are the same bit by bit
        for name in names:
            found.setdefault(name, {}).setdefault((sea.seed, sea.wave), {})[sea.cell] = computed[sea][name]
    return {name: TableRuns(records) for name, records in found.items()}
