"""Beyond the thesis (chapter 7.3): damage at hot spots, load factors, error estimates, sampling, seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
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
from owt_campaign.studies.sea_table import Cell, few_cells, load_case_table, occurrence
from owt_campaign.studies.store import Store
from owt_campaign.studies.stress_runs import StressRuns
from owt_campaign.studies.wave_comparison import processes, table_plan
from owt_campaign.studies.wave_totals import TableRuns, run_table
from owt_postproc.core.stage import BINS_PER_DECADE, LOWEST_PA

__all__ = [
    "Beyond",
    "Joint",
    "SeedScatter",
    "beyond_study",
    "cells_for",
    "load_factor",
    "proxies",
    "seed_scatter",
]

#: Relative error that is asked for, and its two-sided quantile of 95 %.
WANTED, QUANTILE = 0.05, 1.96


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
    """

    name: str
    spot: str
    kind: str
    level: float
    damage: float
    ratio: float
    spread: tuple[float, float]
    factor: float


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
    basis: Mapping[str, BasisErrors]
    basis_cells: Sequence[Cell]

    @property
    def joints(self) -> list[Joint]:
        """Over the linear model that is compared throughout."""
        return self.by_linear[LINEAR]

    def cell_damage(self, seed: int | None = None, wave: str = SECOND_ORDER) -> dict[Cell, float]:
        """Damage of the worst hot spot in 600 s of each cell, mean of the seeds where none is named."""
        seeds = self.table.seeds(wave) if seed is None else [seed]
        found = _by_seed(self.table, self.worst, wave, seeds)
        return {cell: float(np.mean(values)) for cell, values in found.items()}


@dataclass(frozen=True)
class SeedScatter:
    """How damage scatters from record to record of one sea state.

    Attributes
    ----------
    variation : float array [cell]
        Coefficient of variation of the damage of one record, by cell.
    pooled : float
        Root of the mean of their squares, each cell by its share of the damage.
    half_width : float
        Half of the 95 % interval of their damage, relative, with as many seeds as there are (bootstrap).
    seeds : int
        How many that is.
    needed_table, needed_cell : float
        Seeds per sea state that bring the table's, and a single sea state's damage within 5 %.
    """

    variation: Float[np.ndarray, " cell"]
    pooled: float
    half_width: float
    seeds: int
    needed_table: float
    needed_cell: float


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
    return Beyond(
        table=table,
        by_linear={wave: _joints(table, model, damage, wave) for wave in table.linears},
        worst=worst,
        errors=errors,
        scatter=seed_scatter(_of_all_seeds(table, worst)),
        basis=basis,
        basis_cells=compared,
    )


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
    found = []
    for spot in worst_of_joints(damage, model).tolist():
        joint = node[spots.end[spot]]
        ratio = [float(b[spot] / a[spot]) for a, b in each]
        value = float(two[spot] / one[spot])
        found.append(
            Joint(
                name=mesh.node_name[joint], spot=spots.name[spot], kind=spots.kind[spots.end[spot]] or "wall",
                level=float(mesh.node_position[joint, 2]), damage=float(damage[spot]), ratio=value,
                spread=(min(ratio), max(ratio)),
                factor=load_factor(half_cycles[spot], model.fatigue.coefficients[spot], value),
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


def _by_seed(table: TableRuns, spot: int, wave: str, seeds: Sequence[int]) -> dict[Cell, list[float]]:
    """Damage of a hot spot by cell, one value per seed."""
    found: dict[Cell, list[float]] = {}
    for seed in seeds:
        for cell, record in table.records[seed, wave].items():
            found.setdefault(cell, []).append(float(record.damage[spot]))
    return found


def _of_all_seeds(table: TableRuns, spot: int) -> dict[Cell, list[float]]:
    """The same by second-order waves, of the cells that have the most seeds."""
    found = _by_seed(table, spot, SECOND_ORDER, table.seeds(SECOND_ORDER))
    most = max(map(len, found.values()))
    return {cell: values for cell, values in found.items() if len(values) == most}


def seed_scatter(damage: Mapping[Cell, Sequence[float]], *, draws: int = 4000) -> SeedScatter:
    """Scatter of the damage over the seeds, and what it means for the table.

    The bootstrap draws seeds anew in every cell; its interval is widened by sqrt(n / (n - 1)), since drawing
    from n values has their biased variance.
    """
    cells = list(damage)
    value, share = np.array([damage[cell] for cell in cells]), occurrence(cells)
    n = value.shape[1]
    variation = value.std(axis=1, ddof=1) / value.mean(axis=1)
    part = share * value.mean(axis=1) / (share @ value.mean(axis=1))
    pooled = float(np.sqrt(part @ variation**2))
    rng = np.random.default_rng(1)
    drawn = value[np.arange(len(cells))[:, None], rng.integers(n, size=(draws, len(cells), n))].mean(axis=2)
    total = drawn @ share
    low, high = np.quantile(total, [0.025, 0.975])
    half = float(0.5 * (high - low) / total.mean() * np.sqrt(n / (n - 1)))
    return SeedScatter(
        variation=variation,
        pooled=pooled,
        half_width=half,
        seeds=n,
        needed_table=n * (half / WANTED) ** 2,
        needed_cell=(QUANTILE * pooled / WANTED) ** 2,
    )


def proxies(damage: Mapping[Cell, float]) -> dict[str, Float[np.ndarray, " cell"]]:
    """Ways to choose sea states before they are run, as weights that sum to 1.

    By probability alone; by probability times a power of Hs; and by probability times a regression of the
    damage on Hs, Tp and direction, fitted to every thirteenth cell (the pilot runs).
    """
    cells = list(damage)
    share, hs = occurrence(cells), np.array([cell.hs_m for cell in cells])
    found = {
        "probability": share,
        "probability x Hs^2": share * hs**2,
        "probability x Hs^3": share * hs**3,
        "probability x Hs^4": share * hs**4,
        "probability x regression": share * _regression(damage),
    }
    return {name: weight / weight.sum() for name, weight in found.items()}


def _regression(damage: Mapping[Cell, float]) -> Float[np.ndarray, " cell"]:
    """Damage by log-linear regression on Hs and Tp."""
    cells = list(damage)
    columns = np.array([[1.0, np.log(cell.hs_m), np.log(cell.tp_s)] for cell in cells])
    log = np.log([damage[cell] for cell in cells])
    pilot: Int[np.ndarray, " pilot"] = np.arange(0, len(cells), 13 if len(cells) > 39 else 1)
    fit = np.linalg.lstsq(columns[pilot], log[pilot], rcond=None)[0]
    return np.asarray(np.exp(columns @ fit))


def cells_for(damage: Mapping[Cell, float]) -> dict[str, tuple[float, int]]:
    """Sea states needed for the table's damage within 5 %, by the way that they are chosen.

    Returns
    -------
    dict of (float, int)
        Draws needed for 95 % confidence when sea states are drawn by the weight, each draw divided by it; and
        how many of the largest weights are needed when these are run, and what they leave out is added in
        proportion to the weights, until the error stays within 5 %.
    """
    cells = list(damage)
    part = occurrence(cells) * np.array([damage[cell] for cell in cells])
    total = float(part.sum())
    found = {}
    for name, weight in proxies(damage).items():
        drawn = weight > 0.0
        variance = float((part[drawn] ** 2 / weight[drawn]).sum()) / total**2 - 1.0
        order = np.argsort(weight)[::-1]
        estimate = np.cumsum(part[order]) / np.cumsum(weight[order])
        beyond = np.flatnonzero(np.abs(estimate / total - 1.0) > WANTED)
        found[name] = (
            (QUANTILE / WANTED) ** 2 * max(variance, 0.0),
            int(beyond[-1]) + 2 if len(beyond) else 1,
        )
    return found


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
