"""Thesis chapter 6.4: reduced models under waves alone (W-O) and under waves and one wind load (W-W).

The same wind load acts in all sea states, a force at the tower top; it is turbulent wind on the simple rotor
of ``wind.thrust``, the thesis' own series is not published.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import SEEDS
from owt_campaign.studies.energies import EnergyModel
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import StudyResult
from owt_campaign.studies.sea_table import Cell, cell_case, load_case_table
from owt_campaign.studies.store import Store
from owt_model.config import WindConfig
from owt_model.mesh import build_mesh
from owt_model.structure import case_structure
from owt_structure_node.core.response import ModalModel, build_modal_model, structure_parts
from owt_structure_node.wind_source import tower_top_load
from owt_wave_node.core.hydro_mesh import case_hydro_mesh
from owt_wave_node.core.stage import WaveStage

__all__ = ["LOADINGS", "MODELS", "SEAS", "WIND", "WindStudy", "run", "wind_study"]

MODELS, LOADINGS = ("CB10M10", "M20"), ("W-O", "W-W")
#: Rated wind speed, where the thrust is largest, towards the direction that most waves travel to.
WIND = {"thrust": {"speed_m_s": 10.5, "direction_deg": 210.0, "seed": 1, "aerodynamic_damping": False}}
#: Sea states of figure 6.7; of the table's directions only 270 degrees has them.
SEAS = {"low": (0.75, 270.0), "medium": (4.25, 270.0), "high": (8.25, 270.0)}
#: Sea states of the full version, by direction the waves come from.
DIRECTIONS, HEIGHTS = (330.0, 270.0), (0.75, 2.25, 4.25, 6.25, 8.25)
#: Load vectors kept of a sea state.
VECTORS = 20


@dataclass(frozen=True)
class WindStudy:
    """What the study found.

    Attributes
    ----------
    error : dict of float arrays [2]
        Relative error of mean and standard deviation of the potential energy, by cell, seed, model, loading.
    share : dict of float arrays [mode]
        Mean potential energy of each mode and vector of CB10M10 over that of all, by cell, seed, loading.
    guyan : dict of float
        Mean energy of the six constraint modes, over that of the jacket's modes and vectors.
    """

    error: dict[tuple[Cell, int, str, str], Float[np.ndarray, " 2"]]
    share: dict[tuple[Cell, int, str], Float[np.ndarray, " mode"]]
    guyan: dict[tuple[Cell, int, str], float]

    @property
    def cells(self) -> list[Cell]:
        """The sea states."""
        return list(dict.fromkeys(cell for cell, _, _, _ in self.error))

    @property
    def seeds(self) -> list[int]:
        """The seeds."""
        return sorted({seed for _, seed, _, _ in self.error})

    def errors(self, model: str, loading: str, seed: int | None = None) -> Float[np.ndarray, "run 2"]:
        """Absolute errors of all runs, or of those of a seed."""
        return np.abs(
            [
                value
                for (_, s, m, w), value in self.error.items()
                if (m, w) == (model, loading) and seed in (None, s)
            ]
        )

    def modal_share(self, name: str, loading: str) -> Float[np.ndarray, "seed 2"]:
        """Share of the fixed-interface modes, and of the first vector, in a sea state of figure 6.7."""
        rows = [
            [share[:10].sum(), share[10]]
            for (cell, _, w), share in self.share.items()
            if w == loading and (cell.hs_m, cell.from_deg) == SEAS[name]
        ]
        return np.array(rows).reshape(-1, 2)


class _Runs:
    """What the runs share."""

    def __init__(self, cells: Sequence[Cell], samples: int, store: Store) -> None:
        self.samples, self.store = samples, store
        case = cell_case(cells[0], samples=samples)
        self.mesh = build_mesh(case_structure(case.structure))
        self.hydro = case_hydro_mesh(case, self.mesh, lowest=-np.inf)
        self.node = np.append(self.hydro.node, self.mesh.tower_top)
        self.damping, self.dt = case.structure.damping, case.time.dt_s
        self.parts = structure_parts(self.mesh, "CB10M10")
        self.full = EnergyModel.of(build_modal_model(self.mesh, "full"), self.node, self.damping, self.dt)
        windy = case.model_copy(update={"wind": WindConfig.model_validate(WIND)})
        load = tower_top_load(windy, self.mesh)
        assert load is not None
        assert load.wrench is not None
        self.wrench = load.wrench

    def run(self, cell: Cell, seed: int) -> dict[str, np.ndarray]:
        case = cell_case(cell, seed=seed, samples=self.samples)
        key = ["wind", self.mesh.structure.content_hash, case.model_dump(mode="json"), WIND]
        return self.store.run(key, lambda: self._computed(cell, seed))

    def _computed(self, cell: Cell, seed: int) -> dict[str, np.ndarray]:
        case = cell_case(cell, seed=seed, samples=self.samples)
        wave = WaveStage(case, self.mesh, hydro=self.hydro)
        nodal = wave.history().nodal.transpose(2, 0, 1).reshape(self.samples, -1)
        basis = wave.load_basis(VECTORS)
        modal = {name: build_modal_model(self.mesh, name, basis, parts=self.parts) for name in MODELS}
        models = {"full": self.full} | {
            name: EnergyModel.of(model, self.node, self.damping, self.dt) for name, model in modal.items()
        }
        found = {}
        for loading in LOADINGS:
            top = self.wrench if loading == "W-W" else np.zeros_like(self.wrench)
            load = np.hstack([nodal, top])
            for name, model in models.items():
                energy = model.potential(load)
                found[f"{name} {loading}"] = np.array([energy.mean(), energy.std()])
            found[f"modes {loading}"] = self._modes(modal["CB10M10"], models["CB10M10"], load)
        return found

    def _modes(
        self, model: ModalModel, energies: EnergyModel, load: Float[np.ndarray, "time load"]
    ) -> Float[np.ndarray, " coordinate"]:
        """Mean of q_i R_i' K R_i q_i / 2 of the constraint modes, vibration modes and vectors [eq. 6.1]."""
        inside = [i for i, name in enumerate(model.coordinate_name) if name.startswith(("TP", "CB", "MTA"))]
        shapes = model.basis[:, inside]
        stiffness = np.einsum("di,di->i", shapes, model.assembly.jacket_stiffness @ shapes)
        q = energies.motion(load).displacement @ model.coordinate[:, inside]
        return np.asarray(0.5 * stiffness * (q**2).mean(axis=0))


def wind_study(cells: Sequence[Cell], seeds: Sequence[int], samples: int, progress: Progress) -> WindStudy:
    """Run sea states with and without wind.

    Parameters
    ----------
    cells : sequence of Cell
        Sea states of the load-case table.
    seeds : sequence of int
        Of the waves; the wind is the same in all runs.
    samples : int
        Length of the records in load steps.
    progress : callable
        Called with the runs done and those in all.

    Raises
    ------
    InputError, ComputationError
        If a case is refused or its result cannot be trusted.
    """
    runs = _Runs(cells, samples, Store())
    study = WindStudy({}, {}, {})
    asked = [(cell, seed) for seed in seeds for cell in cells]
    for done, (cell, seed) in enumerate(asked):
        found = runs.run(cell, seed)
        for loading in LOADINGS:
            for name in MODELS:
                error = found[f"{name} {loading}"] / found[f"full {loading}"] - 1.0
                study.error[cell, seed, name, loading] = error
            energy = found[f"modes {loading}"]
            study.share[cell, seed, loading] = energy[6:] / energy[6:].sum()
            study.guyan[cell, seed, loading] = float(energy[:6].sum() / energy.sum())
        progress(done + 1, len(asked))
    return study


def run(*, full: bool, progress: Progress) -> StudyResult:
    """The study: ten sea states, three seeds; reduced: two of 100 s, one seed."""
    from owt_campaign.studies.wind_page import wind_result

    table = load_case_table()
    if full:
        cells = [cell for cell in table if cell.from_deg in DIRECTIONS and cell.hs_m in HEIGHTS]
        return wind_result(wind_study(cells, SEEDS, 6000, progress), full=True)
    cells = [cell for cell in table if (cell.hs_m, cell.from_deg) in (SEAS["low"], SEAS["high"])]
    return wind_result(wind_study(cells, SEEDS[:1], 1000, progress), full=False)
