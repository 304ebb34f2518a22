"""Runs of thesis chapter 5: sea states of the load-case table by several wave models on several structures.

Each run has load vectors of its own loads, enough of them that what they leave out is far below what the
studies compare; structures share the loads of a sea state. What is kept of a run are sums over its record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cache

import numpy as np
from jaxtyping import Float, Int

from owt_campaign.engine import evaluate_case, prepare_model
from owt_campaign.shared_model import SharedModel, case_response
from owt_campaign.studies.cases import SECOND_ORDER
from owt_campaign.studies.sea_table import Cell, cell_case, load_case_table
from owt_campaign.studies.store import Store
from owt_campaign.studies.total_stress import TotalStress
from owt_model.config import CaseConfig
from owt_model.contracts import LoadBasis
from owt_model.mesh import Mesh
from owt_postproc.core import stage as fatigue_stage
from owt_postproc.core.rainflow import rainflow
from owt_structure_node.core.pieces import Pieces
from owt_structure_node.core.response_model import n_mta
from owt_wave_node.core.stage import WaveStage

__all__ = ["BIN_PA", "REDUCTION", "STEP_S", "Sea", "StressRecord", "StressRuns", "compute_run", "leg_ends"]

#: Basis of all runs.
REDUCTION = "CB20M40"
#: Integration step in s, that of the loads: exact for loads that are linear between their samples.
STEP_S = 0.1
#: Width in Pa and number of the bins of von Mises ranges that figure 5.2 shows.
BIN_PA, BINS = 1e4, 200
#: Diameter in m of the members whose ranges are binned: the legs.
LEG_DIAMETER = 1.2
#: Load samples worked on at a time.
PIECE = 500


@dataclass(frozen=True)
class Sea:
    """The waves of a run: sea state, seed, wave model, cut-off; phases of its own or those of all others."""

    cell: Cell
    seed: int = 1
    wave: str = SECOND_ORDER
    cutoff: str = "4 omega_p"
    shared_phases: bool = False


@dataclass(frozen=True)
class StressRecord:
    """What is kept of a run.

    Attributes
    ----------
    total_stress : float array [end]
        Sum of range times count of the von Mises stress in Pa.
    leg_ranges : float array [leg end, bin]
        Cycles of the von Mises stress in bins of :data:`BIN_PA`.
    energy : float array [5]
        Mean and standard deviation of the potential, of the kinetic energy, and the largest kinetic, in J.
    damage : float array [spot]
        Palmgren-Miner sum of each hot spot of the reference structure; empty of the others.
    half_cycles : int array [spot, bin]
        Half cycles of each per range bin.
    """

    total_stress: Float[np.ndarray, " end"]
    leg_ranges: Float[np.ndarray, "leg_end bin"]
    energy: Float[np.ndarray, " 5"]
    damage: Float[np.ndarray, " spot"]
    half_cycles: Int[np.ndarray, "spot bin"]


class StressRuns:
    """Runs on several structures.

    Parameters
    ----------
    samples : int
        Length of the records in load steps.
    store : Store, optional
        Where runs are kept.
    """

    def __init__(self, *, samples: int = 6000, store: Store | None = None) -> None:
        self.samples, self.store = samples, Store() if store is None else store
        self._models: dict[str, SharedModel] = {}

    def case(self, sea: Sea, structure: str = "reference") -> CaseConfig:
        """Case of a run."""
        case = cell_case(
            sea.cell, seed=sea.seed, samples=self.samples, wave=sea.wave, cutoff=sea.cutoff,
            structure=structure, reduction=REDUCTION, shared_phases=sea.shared_phases,
        )  # fmt: skip
        step = {"dt_s": STEP_S, "integrator": "exact"}
        return case.model_copy(update={"structure": case.structure.model_copy(update=step)})

    @property
    def mesh(self) -> Mesh:
        """The structure."""
        return self.model("reference").mesh

    def model(self, structure: str) -> SharedModel:
        """What the runs on a structure share."""
        if structure not in self._models:
            self._models[structure] = prepare_model(self.case(Sea(load_case_table()[0]), structure))
        return self._models[structure]

    def key(self, sea: Sea, *more: object) -> list[object]:
        """All that a run depends on."""
        return ["stress", self.case(sea).model_dump(mode="json", exclude={"stream"}), *more]

    def records(self, sea: Sea, structures: Sequence[str] = ("reference",)) -> dict[str, StressRecord]:
        """Return the runs of a sea on several structures, computed unless they are kept."""
        found = self.store.run(self.key(sea, list(structures)), lambda: self._computed(sea, structures))
        parts = [field.name for field in fields(StressRecord)]
        return {
            name: StressRecord(**{part: found[f"{part} {name}"] for part in parts}) for name in structures
        }

    def _computed(self, sea: Sea, structures: Sequence[str]) -> dict[str, np.ndarray]:
        first = self.model("reference")
        waves = WaveStage(self.case(sea), first.mesh, hydro=first.hydro)
        basis = waves.load_basis(n_mta(REDUCTION))
        found: dict[str, np.ndarray] = {}
        for name in structures:
            record = self._record(
                self.case(sea, name), self.model(name), waves, basis, counted=name == "reference"
            )
            found |= {f"{part.name} {name}": getattr(record, part.name) for part in fields(record)}
        return found

    def _record(
        self, case: CaseConfig, shared: SharedModel, waves: WaveStage, basis: LoadBasis, *, counted: bool
    ) -> StressRecord:
        """Response of a structure to the loads of a sea, and what is kept of it."""
        # Loads and their vectors know nothing of the stiffness.
        basis = replace(basis, model_hash=shared.mesh.structure.content_hash)
        response = case_response(shared, case, basis, None)
        legs, fatigue = leg_ends(shared.mesh), fatigue_stage.initial_state(shared.fatigue)
        total, of_legs, potential, kinetic = TotalStress(), [], [], []
        pieces, state = None, None
        for load in waves.load_rows(0, PIECE):  # the records are of one window
            pieces = Pieces(response, load) if pieces is None else pieces
            state, piece = pieces.step(state, load)
            if counted:
                fatigue = fatigue_stage.count_rows(shared.fatigue, fatigue, piece.stress)
            total.add(piece.von_mises)
            of_legs.append(piece.von_mises[legs])
            potential.append(piece.potential)
            kinetic.append(piece.kinetic)
        leg_stress = np.concatenate(of_legs, axis=1)
        p, k = np.concatenate(potential), np.concatenate(kinetic)
        damage, half_cycles = np.zeros(0), np.zeros((0, 0), dtype=np.int32)
        if counted:
            result = fatigue_stage.final(shared.fatigue, fatigue)
            damage, half_cycles = result.damage, np.rint(2.0 * result.histogram).astype(np.int32)
        return StressRecord(
            total_stress=total.value,
            leg_ranges=np.array([_binned(stress) for stress in leg_stress]),
            energy=np.array([p.mean(), p.std(), k.mean(), k.std(), k.max()]),
            damage=damage,
            half_cycles=half_cycles,
        )

    def series(self, sea: Sea, keep: Sequence[str], structure: str = "reference") -> dict[str, np.ndarray]:
        """Series of a run, by their names in :mod:`owt_campaign.kept_series`, at :data:`STEP_S`."""
        key = self.key(sea, structure, list(keep))
        return self.store.run(
            key, lambda: evaluate_case(self.case(sea, structure), self.model(structure), keep=keep).series
        )


@cache
def _runs(samples: int) -> StressRuns:
    """Runs of this process."""
    return StressRuns(samples=samples)


def compute_run(samples: int, sea: Sea, structures: Sequence[str]) -> dict[str, StressRecord]:
    """Records of a sea as :meth:`StressRuns.records` gives them, in whatever process this is."""
    return _runs(samples).records(sea, structures)


def leg_ends(mesh: Mesh) -> list[int]:
    """Member ends of the legs, those inside the transition piece left out."""
    inside = set(mesh.interface_node.tolist())
    legs = [
        m
        for m in range(mesh.n_members)
        if mesh.element_diameter[mesh.member_element[m, 0]] == LEG_DIAMETER
        and not inside.issuperset(mesh.member_node[m].tolist())
    ]
    return [2 * m + side for m in legs for side in (0, 1)]


def _binned(stress: Float[np.ndarray, " sample"]) -> Float[np.ndarray, " bin"]:
    """Cycles per bin of ranges; what lies beyond the last one is left out."""
    ranges, _, counts = rainflow(stress)
    place = (ranges / BIN_PA).astype(int)
    inside = place < BINS
    return np.bincount(place[inside], weights=counts[inside], minlength=BINS)
