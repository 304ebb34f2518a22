"""Beyond the thesis (chapter 7.3): damage at hot spots, load factors, error estimates, sampling, seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import brentq

from owt_campaign.shared_model import SharedModel
from owt_campaign.studies.basis_errors import (
    BasisErrors,
    basis_errors,
    compared_cells,
    worst_of_joints,
)
from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.reduction import further_seeds
from owt_campaign.studies.reduction_runs import SPECIFIC, SeaErrors, table_errors
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sampling import (
    QUANTILE,
    RELEVANT,
    Sampling,
    SeedScatter,
    cell_damage,
    heaviest,
    sampling,
    seed_scatter,
    table_variation,
    variation_of,
)
from owt_campaign.studies.sea_table import Cell, few_cells, load_case_table
from owt_campaign.studies.store import Store
from owt_campaign.studies.stress_runs import StressRuns
from owt_campaign.studies.wave_comparison import processes, table_plan
from owt_campaign.studies.wave_totals import Part, TableRuns, run_table
from owt_postproc.core.stage import BINS_PER_DECADE, LOWEST_PA

__all__ = [
    "HEAVIEST",
    "MANY_SEEDS",
    "Beyond",
    "Joint",
    "beyond_study",
    "estimate_quality",
    "load_factor",
]

#: Sea states and seeds of the comparison of own and shared phases.
HEAVIEST, MANY_SEEDS = 10, 12


@dataclass(frozen=True)
class Joint:
    """Damage of a joint's worst hot spot, second order over linear.

    Attributes
    ----------
    name, spot, kind : str
        Of the joint, of its hot spot of most damage by the second order, and the class of its connection.
    level : float
        z in m.
    damage : float
        By the second order, weighted, of 600 s.
    ratio : float
        Of the damage of that spot by linear waves, all seeds.
    spread : tuple of float
        The same of single seeds, lowest and highest.
    factor : float
        Factor on the stress of the linear waves that gives the damage of the second order.
    factor_spread : tuple of float
        The same of single seeds.
    """

    name: str
    spot: str
    kind: str
    level: float
    damage: float
    ratio: float
    spread: tuple[float, float]
    factor: float
    factor_spread: tuple[float, float]


@dataclass(frozen=True)
class Beyond:
    """What the study found.

    Attributes
    ----------
    table : TableRuns
        Reference structure over the table.
    by_linear : dict of lists of Joint
        Over each linear model; the most damaged first.
    worst : int
        Hot spot of most damage.
    errors : dict
        Errors of reduced models by seed and cell.
    scatter : SeedScatter
        Of the damage of the worst hot spot.
    joint_half_width : float array [joint]
        Half of the 95 % interval of the table's damage at the relevant joints, relative.
    variation : dict of float
        Coefficient of variation of the damage of the worst hot spot in the :data:`HEAVIEST` sea states
        together, from seed to seed, with "own" phases of each of them and with "shared" ones.
    sampling : dict of Sampling
        Sea states needed, by the way they are chosen.
    basis : dict of BasisErrors
        Stress and damage of reduced models against the unreduced one, by basis.
    basis_cells : list of Cell
        Sea states that these errors are of.
    """

    table: TableRuns
    by_linear: Mapping[str, list[Joint]]
    worst: int
    errors: Mapping[int, Mapping[Cell, SeaErrors]]
    scatter: SeedScatter
    joint_half_width: Float[np.ndarray, " joint"]
    variation: Mapping[str, float]
    sampling: Mapping[str, Sampling]
    basis: Mapping[str, BasisErrors]
    basis_cells: Sequence[Cell]

    @property
    def joints(self) -> list[Joint]:
        """Over the linear model that is compared throughout."""
        return self.by_linear[LINEAR]

    def relevant(self, linear: str = LINEAR) -> list[Joint]:
        """Joints of more than :data:`~owt_campaign.studies.sampling.RELEVANT` of the largest damage."""
        joints = self.by_linear[linear]
        return [joint for joint in joints if joint.damage > RELEVANT * joints[0].damage]

    def cell_damage(self, seed: int | None = None, wave: str = SECOND_ORDER) -> dict[Cell, float]:
        """Damage of the worst hot spot in the record of each cell, mean of the seeds where none is named."""
        found = cell_damage(self.table, wave, seed)
        return {cell: float(damage[self.worst]) for cell, damage in found.items()}


def beyond_study(*, full: bool, progress: Progress) -> Beyond:
    """Run the study."""
    cells = list(load_case_table()) if full else few_cells()
    samples, store = 6000 if full else 1200, Store()
    runs = StressRuns(samples=samples, store=store)
    table = run_table(samples, table_plan(cells, full=full), progress, workers=processes(full=full))[
        "reference"
    ]
    errors = table_errors(
        cells, further_seeds(cells, full=full), samples=samples, store=store, progress=progress
    )
    compared = compared_cells(full=full)
    basis = basis_errors(runs, compared, progress)
    damage = table.total(SECOND_ORDER, part="damage")
    worst = int(damage.argmax())
    model = runs.model("reference")
    joints = worst_of_joints(damage, model)
    joints = joints[damage[joints] > RELEVANT * damage[worst]]
    by_seed = [cell_damage(table, SECOND_ORDER, seed) for seed in table.seeds()]
    return Beyond(
        table=table,
        by_linear={wave: _joints(table, model, damage, wave) for wave in table.linears},
        worst=worst,
        errors=errors,
        scatter=seed_scatter({cell: [float(of[cell][worst]) for of in by_seed] for cell in by_seed[0]}),
        joint_half_width=QUANTILE * table_variation(table)[joints] / np.sqrt(len(by_seed)),
        variation=_phases_compared(table, worst, samples, progress, full=full),
        sampling=sampling(table, worst, joints),
        basis=basis,
        basis_cells=compared,
    )


def _phases_compared(
    table: TableRuns, worst: int, samples: int, progress: Progress, *, full: bool
) -> dict[str, float]:
    """Scatter of the damage from seed to seed with own and with shared phases."""
    mean = cell_damage(table, SECOND_ORDER)
    cells = heaviest({cell: float(damage[worst]) for cell, damage in mean.items()}, HEAVIEST)
    plan: list[Part] = [(seed, SECOND_ORDER, cells, ("reference",)) for seed in range(1, MANY_SEEDS + 1)]
    workers = processes(full=full)
    return {
        name: variation_of(
            run_table(samples, plan, progress, workers=workers, shared_phases=shared)["reference"], worst
        )
        for name, shared in (("own", False), ("shared", True))
    }


def _joints(
    table: TableRuns, model: SharedModel, damage: Float[np.ndarray, " spot"], linear: str
) -> list[Joint]:
    """Damage of the second order, `damage` in all, over that of a linear model."""
    mesh, spots = model.mesh, model.fatigue.hot_spots
    node = mesh.member_node.reshape(-1)
    one, two = (
        table.total(wave, part="damage", like=other)
        for wave, other in ((linear, SECOND_ORDER), (SECOND_ORDER, linear))
    )
    each = [
        (table.total(linear, s, part="damage"), table.total(SECOND_ORDER, s, part="damage", like=linear))
        for s in table.seeds(linear)
    ]
    half_cycles = table.total(linear, part="half_cycles", like=SECOND_ORDER)
    of_seeds = [table.total(linear, s, part="half_cycles", like=SECOND_ORDER) for s in table.seeds(linear)]
    found = []
    for spot in worst_of_joints(damage, model).tolist():
        joint = node[spots.end[spot]]
        ratio = [float(b[spot] / a[spot]) for a, b in each]
        value, curve = float(two[spot] / one[spot]), model.fatigue.coefficients[spot]
        factor = [load_factor(n[spot], curve, r) for n, r in zip(of_seeds, ratio, strict=True)]
        found.append(
            Joint(
                name=mesh.node_name[joint], spot=spots.name[spot], kind=spots.kind[spots.end[spot]] or "wall",
                level=float(mesh.node_position[joint, 2]), damage=float(damage[spot]), ratio=value,
                spread=(min(ratio), max(ratio)),
                factor=load_factor(half_cycles[spot], curve, value),
                factor_spread=(min(factor), max(factor)),
            )
        )  # fmt: skip
    return sorted(found, key=lambda joint: -joint.damage)


def load_factor(
    half_cycles: Float[np.ndarray, " bin"], curve: Float[np.ndarray, " 5"], ratio: float
) -> float:
    """Factor on all ranges that multiplies the damage of counted ranges by `ratio`.

    Parameters
    ----------
    half_cycles : float array [bin]
        Half cycles per range bin, as :mod:`owt_postproc.core.stage` counts them.
    curve : float array [5]
        S-N coefficients: knee in Pa, then 1/a and m above and below it.
    ratio : float
        Damage wanted over that of the ranges.
    """
    middle = LOWEST_PA * 10.0 ** ((np.arange(len(half_cycles)) - 0.5) / BINS_PER_DECADE)
    knee, upper, m_upper, lower, m_lower = curve

    def damage(factor: float) -> float:
        r = factor * middle
        return float(half_cycles @ np.where(r >= knee, upper * r**m_upper, lower * r**m_lower))

    whole = damage(1.0)
    return float(brentq(lambda factor: damage(factor) / whole - ratio, 0.1, 10.0))


def estimate_quality(errors: Mapping[int, Mapping[Cell, SeaErrors]]) -> dict[str, dict[str, float]]:
    """True over estimated error of the mean energy, of the estimate and of the share of energy left out."""
    runs = [record for cells in errors.values() for record in cells.values()]
    found = {}
    for name in SPECIFIC:
        true = np.array([run.mean[name] for run in runs])
        ratio = true / np.array([run.estimate[name] for run in runs])
        found[name] = {
            "largest true error": float(true.max()),
            "median ratio": float(np.median(ratio)),
            "largest ratio": float(ratio.max()),
            "covered": float((ratio <= 1.0).mean()),
        }
        kept = {"CB10M10": 10, "M20": 20}.get(name)
        if kept is not None:
            left = np.array([1.0 - run.pov[:kept].sum() for run in runs])
            found[name]["median ratio, energy left out"] = float(np.median(true / left))
    return found
