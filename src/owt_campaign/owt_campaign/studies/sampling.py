"""How few sea states and seeds give the damage of a load-case table (thesis 4.4.1, 7.3.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from owt_campaign.studies.cases import SECOND_ORDER
from owt_campaign.studies.sea_table import Cell, load_case_table, occurrence
from owt_campaign.studies.wave_totals import TableRuns

__all__ = [
    "QUANTILE",
    "RELEVANT",
    "WANTED",
    "Sampling",
    "SeedScatter",
    "cell_damage",
    "draws_needed",
    "heaviest",
    "largest_needed",
    "pilots",
    "proxies",
    "sampling",
    "seed_scatter",
    "table_variation",
    "variation_of",
]

#: Relative error that is asked for, and its two-sided quantile of 95 %.
WANTED, QUANTILE = 0.05, 1.96
#: Least damage of a hot spot that counts, over the largest one.
RELEVANT = 0.01
#: Every how many-th sea state the regression is fitted to; all of a table that has few.
PILOT, FEW = 13, 39


@dataclass(frozen=True)
class SeedScatter:
    """How damage scatters from record to record when every sea state has phases of its own.

    Attributes
    ----------
    variation : float array [cell]
        Coefficient of variation of the damage of one record, by cell.
    pooled : float
        Root of the mean of their squares, each cell by its share of the damage.
    half_width : float
        Half of the 95 % interval of the table's damage, relative, with as many seeds (bootstrap).
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


@dataclass(frozen=True)
class Sampling:
    """Sea states needed for the table's damage within 5 %, by one way to choose them.

    Attributes
    ----------
    draws : float
        Random draws at the most damaged hot spot, as :func:`draws_needed`.
    largest : int
        Sea states of largest weight there, as :func:`largest_needed`, by the mean of the seeds.
    seeds : tuple of int
        The same by single seeds, fewest and most.
    joints : tuple of float
        The same at the worst hot spots of the joints, median and most.
    """

    draws: float
    largest: int
    seeds: tuple[int, int]
    joints: tuple[float, int]


def cell_damage(
    table: TableRuns, wave: str, seed: int | None = None
) -> dict[Cell, Float[np.ndarray, " spot"]]:
    """Damage of each hot spot in the records of each sea state, mean of the seeds where none is named."""
    seeds = table.seeds(wave) if seed is None else [seed]
    records = [table.records[number, wave] for number in seeds]
    return {cell: np.mean([of[cell].damage for of in records], axis=0) for cell in records[0]}


def seed_scatter(damage: Mapping[Cell, Sequence[float]], *, draws: int = 4000) -> SeedScatter:
    """Scatter of the damage over the seeds, and what it means for the table.

    The bootstrap draws seeds anew in every cell, which have phases of their own; its interval is widened by
    sqrt(n / (n - 1)), since drawing from n values has their biased variance.
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


def table_variation(table: TableRuns) -> Float[np.ndarray, " spot"]:
    """Coefficient of variation of the table's damage by one seed, sea states independent, second order.

    The variances of the sea states add up: each of them is known by its few seeds only, their sum well.
    """
    damage = [np.array(list(cell_damage(table, SECOND_ORDER, seed).values())) for seed in table.seeds()]
    share = occurrence(table.cells(table.seeds()[0]))
    variance = share**2 @ np.var(damage, axis=0, ddof=1)
    return np.asarray(np.sqrt(variance) / (share @ np.mean(damage, axis=0)))


def heaviest(damage: Mapping[Cell, float], count: int) -> list[Cell]:
    """The sea states that contribute most to the table's damage."""
    contribution = occurrence(list(damage)) * np.array(list(damage.values()))
    return [list(damage)[place] for place in np.argsort(contribution)[::-1][:count]]


def variation_of(table: TableRuns, spot: int) -> float:
    """Coefficient of variation of the damage of a hot spot from seed to seed, of all sea states together."""
    share = dict(zip(load_case_table(), occurrence(load_case_table()), strict=True))
    total = [
        sum(share[cell] * float(of[spot]) for cell, of in cell_damage(table, SECOND_ORDER, seed).items())
        for seed in table.seeds()
    ]
    return float(np.std(total, ddof=1) / np.mean(total))


def proxies(damage: Mapping[Cell, float]) -> dict[str, Float[np.ndarray, " cell"]]:
    """Ways to choose sea states before they are run, as weights that sum to 1.

    By probability alone; by probability times a power of Hs; and by probability times a regression of the
    damage on Hs and Tp, fitted to every :data:`PILOT`-th cell (the pilot runs).
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


def pilots(count: int) -> Int[np.ndarray, " pilot"]:
    """Places of the pilot runs among `count` cells."""
    return np.arange(0, count, PILOT if count > FEW else 1)


def _regression(damage: Mapping[Cell, float]) -> Float[np.ndarray, " cell"]:
    """Damage by log-linear regression on Hs and Tp."""
    cells = list(damage)
    columns = np.array([[1.0, np.log(cell.hs_m), np.log(cell.tp_s)] for cell in cells])
    log = np.log([damage[cell] for cell in cells])
    pilot = pilots(len(cells))
    fit = np.linalg.lstsq(columns[pilot], log[pilot], rcond=None)[0]
    return np.asarray(np.exp(columns @ fit))


def draws_needed(weight: Float[np.ndarray, " cell"], contribution: Float[np.ndarray, " cell"]) -> float:
    """Draws of sea states by `weight`, each divided by it, for their sum within 5 % with 95 % confidence.

    Parameters
    ----------
    weight : float array [cell]
        Chance of each to be drawn.
    contribution : float array [cell]
        Damage times probability of each.
    """
    drawn, total = weight > 0.0, float(contribution.sum())
    variance = float((contribution[drawn] ** 2 / weight[drawn]).sum()) / total**2 - 1.0
    return (QUANTILE / WANTED) ** 2 * max(variance, 0.0)


def largest_needed(weight: Float[np.ndarray, " cell"], contribution: Float[np.ndarray, " cell"]) -> int:
    """How many sea states of largest `weight` give the sum within 5 %, and all larger numbers too.

    What is not run is added in proportion to the weights. Parameters as :func:`draws_needed`.
    """
    order = np.argsort(weight)[::-1]
    estimate = np.cumsum(contribution[order]) / np.cumsum(weight[order])
    beyond = np.flatnonzero(np.abs(estimate / contribution.sum() - 1.0) > WANTED)
    return int(beyond[-1]) + 2 if len(beyond) else 1


def sampling(table: TableRuns, worst: int, joints: Int[np.ndarray, " joint"]) -> dict[str, Sampling]:
    """Compare the ways of :func:`proxies` to choose sea states, second order.

    Parameters
    ----------
    table : TableRuns
        Runs of all sea states.
    worst : int
        Hot spot that the regression is fitted to.
    joints : int array [joint]
        Hot spots at which the choice is judged too.
    """
    each = {seed: cell_damage(table, SECOND_ORDER, seed) for seed in table.seeds()}
    mean = cell_damage(table, SECOND_ORDER)
    share = occurrence(list(mean))
    contribution = share[:, None] * np.array(list(mean.values()))
    single = [share * np.array([damage[worst] for damage in cells.values()]) for cells in each.values()]
    found = {}
    for name, weight in proxies({cell: float(damage[worst]) for cell, damage in mean.items()}).items():
        by_seed = [largest_needed(weight, part) for part in single]
        at_joints = [largest_needed(weight, contribution[:, spot]) for spot in joints.tolist()]
        found[name] = Sampling(
            draws=draws_needed(weight, contribution[:, worst]),
            largest=largest_needed(weight, contribution[:, worst]),
            seeds=(min(by_seed), max(by_seed)),
            joints=(float(np.median(at_joints)), max(at_joints)),
        )
    return found
