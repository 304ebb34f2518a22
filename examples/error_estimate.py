"""Estimated against true errors of reduced models, over cells of the load-case table.

For each sea state the unreduced model is integrated, mode by mode, and so is each reduced one; their
difference in mean potential energy and in the stress at member ends is set against what was estimated from
the loads alone. docs/error_estimate.md says what came of it.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_model.config import CaseConfig, parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.assembly import assemble
from owt_structure_node.core.error_estimate import ErrorModel
from owt_structure_node.core.reduction import reduce
from owt_structure_node.core.stage import ResponseModel, build_response_model, initial_state, step
from owt_wave_node.core.stage import WaveStage, build_wave_stage

ROOT = Path(__file__).parents[1]
#: Sea states kept for the judgement: every eighth cell of the table from this one on.
FIRST, EVERY, COUNT = 5, 8, 20
WITHOUT_VECTORS = ("CB00", "CB10", "CB20", "CB20+SIM")
WITH_VECTORS = ("CB10M05", "M10", "CB10M10", "M20", "CB10M20", "CB10M10j1", "CB10M10Y")
INK = "#1c2733"


def case_of(cell: dict[str, str], reduction: str, *, n: int, seed: int) -> CaseConfig:
    # The table says where waves come from, clockwise from north; x points north, y west.
    sea = {"hs_m": float(cell["hs_m"]), "tp_s": float(cell["tp_s"]), "seed": seed}
    sea["direction_deg"] = (180.0 - float(cell["direction_deg"])) % 360.0
    structure = {"model": "oc4-thesis", "reduction": reduction, "dt_s": 0.1, "integrator": "exact"}
    return parse_case({"sea_state": sea, "time": {"n": n}, "structure": structure, "stream": {"block": n}})


def response(model: ResponseModel, waves: WaveStage) -> tuple[float, np.ndarray]:
    """Mean potential energy, and stress by normal force and moments [sample, end, 3]."""
    found = step(model, initial_state(model), waves.load_block(0))[1]
    stress = np.stack([found.stress.axial, found.stress.bending_y, found.stress.bending_z], axis=-1)
    return float(found.energy.potential.mean()), stress


def judge(count: int, n: int, models: tuple[str, ...]) -> np.ndarray:
    """True and estimated errors [sea state, model, (true energy, estimate, true force, estimate)]."""
    with (ROOT / "test" / "data" / "waves" / "load_cases.csv").open() as file:
        cells = list(csv.DictReader(line for line in file if not line.startswith("#")))
    mesh, rows = build_mesh(load_structure("oc4-thesis")), []
    assembly, full = assemble(mesh), None
    for seed, cell in list(enumerate(cells[FIRST::EVERY][:COUNT], 1))[-count:]:
        case = case_of(cell, "full", n=n, seed=seed)
        full = build_response_model(case, mesh, None) if full is None else full
        waves = build_wave_stage(case, mesh)
        basis = waves.load_basis(30)
        errors = ErrorModel(assembly, basis, damping=case.structure.damping, dt=case.time.dt_s)
        energy, stress = response(full, waves)
        spread = np.sqrt(stress.var(axis=0).sum(axis=-1))
        relevant = spread > 0.01 * spread.max()
        for name in models:
            model = build_response_model(case_of(cell, name, n=n, seed=seed), mesh, basis)
            reduced_energy, reduced_stress = response(model, waves)
            force = np.sqrt((reduced_stress - stress).var(axis=0).sum(axis=-1))[relevant] / spread[relevant]
            estimate = errors.estimate(reduce(assembly, name, basis))
            true = abs(reduced_energy / energy - 1.0)
            rows.append((true, estimate.energy, force.max(), estimate.member_force))
    return np.array(rows).reshape(-1, len(models), 4)


def draw(found: np.ndarray, models: tuple[str, ...], picture: Path) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 5.0), layout="constrained")
    for k, title in enumerate(("mean potential energy", "member-end force, worst end")):
        true, estimate = found[..., 2 * k], found[..., 2 * k + 1]
        for i, name in enumerate(models):
            look = {"marker": "osDX^v<>ph*"[i], "color": f"C{i}" if i < 10 else INK, "label": name}
            axes[k].loglog(estimate[:, i], true[:, i], ls="", ms=5, alpha=0.8, **look)
        ends = np.array([min(estimate.min(), true.min()), max(estimate.max(), true.max())]) * [0.7, 1.4]
        axes[k].plot(ends, ends, color=INK, lw=1.0, label="true = estimated")
        axes[k].set(xlabel="estimated relative error", ylabel="true relative error", title=title)
    axes[0].legend(fontsize=8)
    figure.savefig(picture, dpi=130)


def main(folder: Path, count: int = 2, n: int = 1200, models: tuple[str, ...] = ("CB10", "CB10M10")) -> None:
    found = judge(count, n, models)
    draw(found, models, folder / "error_estimate.png")
    energy, force = found[..., 0] / found[..., 1], found[..., 2] / found[..., 3]
    print(f"energy: {np.mean(energy <= 1.0):.0%} within the estimate, median ratio {np.median(energy):.2f}")
    print(f"member force: {np.mean(force <= 1.0):.0%}, {np.median(force):.2f}, largest {force.max():.2f}")
    assert np.mean(energy <= 1.0) > 0.9
    assert 0.5 < force.min() < force.max() < 2.0


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]), COUNT, 6000, WITHOUT_VECTORS + WITH_VECTORS)
