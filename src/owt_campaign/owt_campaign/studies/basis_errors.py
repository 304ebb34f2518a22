"""What a small error of the energy hides: stress and damage of reduced models against the unreduced one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_campaign.engine import evaluate_case, prepare_model
from owt_campaign.shared_model import SharedModel
from owt_campaign.studies.cases import LINEAR, SECOND_ORDER
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, few_cells, load_case_table
from owt_campaign.studies.stress_runs import Sea, StressRuns
from owt_model.config import CaseConfig

__all__ = ["BasisErrors", "basis_errors", "compared_cells", "worst_of_joints"]

BASES = ("CB10M10", "CB10M20", "CB20M20", "CB20M40", "CB20M80")
WAVES = (LINEAR, SECOND_ORDER)
#: Total stress of an end, and damage of a joint, of the largest one, below which they are not looked at.
RELEVANT = 1e-3


@dataclass(frozen=True)
class BasisErrors:
    """Relative errors of one basis, with load vectors of each run's own loads, over sea states and waves.

    Attributes
    ----------
    energy : float
        Largest error of the mean potential energy.
    stress, stress_median, stress_ratio : float
        Largest error of the total stress of a member end, the median of the ends, and the largest one of its
        ratio second order over linear.
    damage, damage_ratio, worst : float
        Largest error of the damage of a joint's worst hot spot, of its ratio, and of the most damaged spot.
    """

    energy: float
    stress: float
    stress_median: float
    stress_ratio: float
    damage: float
    damage_ratio: float
    worst: float


Arrays = dict[str, np.ndarray]


def compared_cells(*, full: bool) -> list[Cell]:
    """A low and two middle sea states, and the highest one; the first alone in the reduced version."""
    return [*few_cells(), load_case_table()[-1]] if full else few_cells()[:1]


def basis_errors(
    runs: StressRuns, cells: Sequence[Cell], progress: Progress, bases: Sequence[str] = BASES
) -> dict[str, BasisErrors]:
    """Compare bases with the unreduced model.

    Parameters
    ----------
    runs : StressRuns
        Gives the cases.
    cells : sequence of Cell
        Sea states, each with linear and second-order waves of seed 1.
    progress : callable
        Called with the runs done and those in all.
    bases : sequence of str
        Reductions.

    Returns
    -------
    dict of BasisErrors
        By basis.
    """
    models = {name: prepare_model(_case(runs, cells[0], LINEAR, name)) for name in ("full", *bases)}
    found: dict[tuple[Cell, str, str], Arrays] = {}
    total = len(cells) * len(WAVES) * len(models)
    for cell in cells:
        for wave in WAVES:
            for name, model in models.items():
                found[cell, wave, name] = _run(runs, cell, wave, name, model)
                progress(len(found), total)
    each = {name: [_errors(found, cell, name, models["full"]) for cell in cells] for name in bases}
    return {
        name: BasisErrors(**{key: max(errors[key] for errors in some) for key in some[0]})
        for name, some in each.items()
    }


def _case(runs: StressRuns, cell: Cell, wave: str, reduction: str) -> CaseConfig:
    case = runs.case(Sea(cell, 1, wave))
    return case.model_copy(update={"structure": case.structure.model_copy(update={"reduction": reduction})})


def _run(runs: StressRuns, cell: Cell, wave: str, reduction: str, model: SharedModel) -> Arrays:
    case = _case(runs, cell, wave, reduction)

    def compute() -> Arrays:
        outcome = evaluate_case(case, model)
        return {
            "stress": outcome.fatigue.total_stress,
            "damage": outcome.fatigue.damage,
            "energy": outcome.energy.potential_mean[:1],
        }

    return runs.store.run(["basis errors", case.model_dump(mode="json", exclude={"stream"})], compute)


def _errors(
    found: dict[tuple[Cell, str, str], Arrays], cell: Cell, name: str, model: SharedModel
) -> dict[str, float]:
    """Errors of one basis in one sea state, the larger one of both wave models."""
    true, ours = ([found[cell, wave, basis] for wave in WAVES] for basis in ("full", name))
    stress = true[1]["stress"] > RELEVANT * true[1]["stress"].max()
    joints = worst_of_joints(true[1]["damage"], model)
    worst = int(true[1]["damage"].argmax())

    def off(key: str, place: Bool[np.ndarray, " end"] | Int[np.ndarray, " spot"]) -> Float[np.ndarray, "2 n"]:
        return np.array([b[key][place] / a[key][place] - 1.0 for a, b in zip(true, ours, strict=True)])

    def of_ratio(error: Float[np.ndarray, "2 n"]) -> float:
        return float(np.abs((1.0 + error[1]) / (1.0 + error[0]) - 1.0).max())

    ends, spots = off("stress", stress), off("damage", joints)
    return {
        "energy": float(np.abs(off("energy", np.array([0]))).max()),
        "stress": float(np.abs(ends).max()),
        "stress_median": float(np.median(np.abs(ends))),
        "stress_ratio": of_ratio(ends),
        "damage": float(np.abs(spots).max()),
        "damage_ratio": of_ratio(spots),
        "worst": float(np.abs(off("damage", np.array([worst]))).max()),
    }


def worst_of_joints(damage: Float[np.ndarray, " spot"], model: SharedModel) -> Int[np.ndarray, " joint"]:
    """Most damaged hot spot of every joint that has damage to speak of, joints in the order of the mesh."""
    node = model.mesh.member_node.reshape(-1)[model.fatigue.hot_spots.end]
    spots = [np.flatnonzero(node == joint) for joint in np.unique(node)]
    worst = np.array([own[damage[own].argmax()] for own in spots])
    return np.asarray(worst[damage[worst] >= RELEVANT * damage.max()])
