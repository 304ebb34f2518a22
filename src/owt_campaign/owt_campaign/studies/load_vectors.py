"""Thesis 7.3.2: how many load vectors steep regular waves (stream function) and NewWave groups need.

The thesis expects that "the larger the wave height, the more MTAs are required". Of each wave the loads are
decomposed; counted are the vectors that carry a share of their variance (figure 6.5), and those with which
the potential energy of a reduced model comes within a tolerance of the unreduced one's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import MODEL, SEEDS
from owt_campaign.studies.energies import EnergyModel
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import StudyResult
from owt_campaign.studies.store import Store
from owt_model.config import CaseConfig, parse_case
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure
from owt_structure_node.core.response import StructureParts, build_modal_model, structure_parts
from owt_wave_node.core.stage import WaveStage

__all__ = [
    "BASES",
    "COUNTS",
    "HEIGHTS",
    "WAVES",
    "Need",
    "borrowed",
    "enough",
    "needs",
    "period",
    "run",
    "wave_case",
]

HEIGHTS = (2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.0)
#: Of these the irregular seas are run too, for comparison.
IRREGULAR = (2.5, 10.0, 17.0)
WAVES = ("stream function", "stream function, one period", "NewWave", "irregular")
#: Vectors tried, and the reductions that have them.
COUNTS = (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30)
BASES = ("CB10M", "M")
#: Shares of the variance of the loads, and tolerance on mean and standard deviation of the potential energy.
SHARES, TOLERANCES = (0.99, 0.999), (1e-3, 1e-4)
GRAVITY = 9.81
#: Highest wave over Hs in about a thousand waves.
HIGHEST = 1.86
#: Length of the records in s: periods of a regular wave, a group, an irregular sea.
PERIODS, GROUP_S, SEA_S = 10, 80.0, 300.0
DIRECTION = 210.0


@dataclass(frozen=True)
class Need:
    """Vectors that a wave needs.

    Attributes
    ----------
    by_share : dict of int
        Vectors that carry each of :data:`SHARES` of the variance of the loads.
    by_energy : dict of int or None
        Vectors with which, and with all larger counts tried, each of :data:`BASES` comes within each of
        :data:`TOLERANCES`; None where not even the largest does.
    first : float
        Share of the first vector.
    error : dict of float
        Larger error of mean and standard deviation of the energy with CB10Mnn, by number of vectors.
    """

    by_share: dict[float, int]
    by_energy: dict[tuple[str, float], int | None]
    first: float
    error: dict[int, float]


def period(height: float) -> float:
    """Shortest period in s that goes with a height: 11.1 sqrt(H/g), the steepest of IEC 61400-3-1."""
    return 11.1 * math.sqrt(height / GRAVITY)


def wave_case(wave: str, height: float, seed: int = 1) -> CaseConfig:
    """Case of a wave of a height.

    The second kind gives all heights the period of the highest. A NewWave group has its linear crest at half
    the height; it and the irregular sea have the Hs of which the height is the highest wave of about a
    thousand.
    """
    t = period(HEIGHTS[-1] if wave == WAVES[1] else height)
    data: dict[str, Any] = {"structure": {"model": MODEL}, "wave": {"order": 2}}
    if wave in WAVES[:2]:
        regular = {"theory": "stream", "height_m": height, "period_s": t, "direction_deg": DIRECTION}
        n = round(PERIODS * t / 0.1)
        return parse_case(data | {"regular": regular, "time": {"n": n}})
    sea: dict[str, Any] = {"hs_m": height / HIGHEST, "tp_s": t, "direction_deg": DIRECTION, "seed": seed}
    length = SEA_S
    if wave == "NewWave":
        length = GROUP_S
        sea["focus"] = {"crest_m": height / 2.0, "time_s": GROUP_S / 2.0, "background": False}
    return parse_case(data | {"sea_state": sea, "time": {"n": round(length / 0.1)}})


class _Structure:
    """What all waves share; the unreduced model is solved when it is first asked for."""

    def __init__(self) -> None:
        self.mesh: Mesh = build_mesh(load_structure(MODEL))
        self.parts: StructureParts = structure_parts(self.mesh, "CB10M30")
        self.case = parse_case({"structure": {"model": MODEL}})

    def energies(self, model: Any, wave: WaveStage) -> EnergyModel:
        node = wave.windows.hydro.node
        return EnergyModel.of(model, node, self.case.structure.damping, self.case.time.dt_s)

    @cached_property
    def full(self) -> Any:
        return build_modal_model(self.mesh, "full")

    def moments(self, wave: WaveStage) -> dict[str, np.ndarray]:
        """Shares of the vectors, and mean and standard deviation of the energy by reduction."""
        nodal = _loads(wave)
        basis = wave.load_basis(COUNTS[-1])
        share = basis.singular_values**2 / basis.total_variance
        found = {"share": share, "full": _moments(self.energies(self.full, wave), nodal)}
        for kind in BASES:
            for count in COUNTS:
                if kind == "M" and not count:
                    continue
                model = build_modal_model(self.mesh, _name(kind, count), basis, parts=self.parts)
                found[f"{kind} {count}"] = _moments(self.energies(model, wave), nodal)
        return found

    def with_vectors_of(self, sea: WaveStage, wave: WaveStage) -> dict[str, np.ndarray]:
        """Mean and standard deviation of a wave's energy with CB10Mnn made of the loads of another one."""
        nodal = _loads(wave)
        basis = sea.load_basis(COUNTS[-1])
        found = {"full": _moments(self.energies(self.full, wave), nodal)}
        for count in COUNTS:
            model = build_modal_model(self.mesh, _name(BASES[0], count), basis, parts=self.parts)
            found[f"{BASES[0]} {count}"] = _moments(self.energies(model, wave), nodal)
        return found


def _name(kind: str, count: int) -> str:
    """Name of a reduction."""
    return f"{kind}{count:02d}".replace("M00", "")


def _loads(wave: WaveStage) -> Float[np.ndarray, "time load"]:
    nodal = wave.history().nodal.transpose(2, 0, 1)
    return np.ascontiguousarray(nodal).reshape(len(nodal), -1)


def needs(
    waves: Sequence[str], heights: Sequence[float], seeds: Sequence[int], progress: Progress
) -> dict[tuple[str, float, int], Need]:
    """Vectors that each wave of each height needs; only irregular seas have several seeds.

    Raises
    ------
    InputError, ComputationError
        If a wave is refused or its loads cannot be computed.
    """
    structure, store = _Structure(), Store()
    asked = [
        (wave, height, seed)
        for wave in waves
        for height in heights
        for seed in (seeds if wave == "irregular" else seeds[:1])
        if wave != "irregular" or height in IRREGULAR
    ]
    found = {}
    for done, (wave, height, seed) in enumerate(asked):
        case = wave_case(wave, height, seed)
        key = ["load vectors", structure.mesh.structure.content_hash, case.model_dump(mode="json"), COUNTS]
        kept = store.run(
            key,
            lambda case=case: structure.moments(WaveStage(case, structure.mesh)),  # type: ignore[misc]
        )
        found[wave, height, seed] = _need(kept)
        progress(done + 1, len(asked))
    return found


def borrowed(
    waves: Sequence[tuple[str, float]], progress: Progress
) -> dict[tuple[str, float], dict[int, float]]:
    """Error of the energy of a wave with the vectors of the irregular sea of its height, by their number.

    Of CB10Mnn, the larger one of mean and standard deviation; the sea has seed 1.

    Parameters
    ----------
    waves : sequence of tuples
        Kind and height in m of each wave.
    progress : callable
        Called with the waves done and those in all.

    Raises
    ------
    InputError, ComputationError
        If a wave is refused or its loads cannot be computed.
    """
    structure, store = _Structure(), Store()
    found = {}
    for done, (wave, height) in enumerate(waves):
        case, sea = wave_case(wave, height), wave_case("irregular", height)
        cases = [one.model_dump(mode="json") for one in (case, sea)]
        key = ["borrowed load vectors", structure.mesh.structure.content_hash, cases, COUNTS]
        kept = store.run(
            key,
            lambda case=case, sea=sea: structure.with_vectors_of(  # type: ignore[misc]
                WaveStage(sea, structure.mesh), WaveStage(case, structure.mesh)
            ),
        )
        found[wave, height] = _errors(kept, BASES[0])
        progress(done + 1, len(waves))
    return found


def _errors(found: dict[str, np.ndarray], kind: str) -> dict[int, float]:
    """Larger error of mean and standard deviation by number of vectors."""
    return {
        count: float(np.abs(found[f"{kind} {count}"] / found["full"] - 1.0).max())
        for count in COUNTS
        if f"{kind} {count}" in found
    }


def enough(error: dict[int, float], tolerance: float) -> int | None:
    """Smallest count from which on an error stays within a tolerance; None where the last one is not."""
    needed = None
    for count in sorted(error, reverse=True):
        if error[count] >= tolerance:
            break
        needed = count
    return needed


def _need(found: dict[str, np.ndarray]) -> Need:
    carried = np.cumsum(found["share"])
    error = {kind: _errors(found, kind) for kind in BASES}
    return Need(
        by_share={share: int(np.searchsorted(carried, share)) + 1 for share in SHARES},
        by_energy={
            (kind, tolerance): enough(error[kind], tolerance)
            for kind, tolerance in product(BASES, TOLERANCES)
        },
        first=float(found["share"][0]),
        error=error[BASES[0]],
    )


def _moments(model: EnergyModel, nodal: Float[np.ndarray, "time load"]) -> Float[np.ndarray, " 2"]:
    energy = model.potential(nodal)
    return np.array([energy.mean(), energy.std()])


def run(*, full: bool, progress: Progress) -> StudyResult:
    """The study: seven heights, four kinds of wave; reduced: two heights of the stream function."""
    from owt_campaign.studies.load_vectors_page import load_vectors_result

    ends = (HEIGHTS[0], HEIGHTS[-1])
    waves, heights = (WAVES, HEIGHTS) if full else (WAVES[:1], ends)
    found = needs(waves, heights, SEEDS, progress)
    kinds = [wave for wave in ("stream function", "NewWave") if wave in waves]
    others = borrowed(list(product(kinds, ends)), progress)
    return load_vectors_result(found, others, full=full)
