"""Runs of thesis chapter 6.2: the load-case table on the unreduced and on the reduced models.

Every sea state is computed once for the unreduced model and for the bases of its own loads (*spec*), and its
load shapes are kept; from those of the first seed come the bases of the clusters (*dir*, *hs*, *tot*), for
which a second pass computes the loads again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.energies import EnergyModel
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, cell_case
from owt_campaign.studies.store import Store
from owt_model.contracts import LoadBasis
from owt_model.mesh import build_mesh
from owt_model.pod import clustered_basis, load_basis
from owt_model.structure import case_structure
from owt_structure_node.core.assembly import Assembly, assemble
from owt_structure_node.core.error_estimate import ErrorModel
from owt_structure_node.core.modes import dense_modes
from owt_structure_node.core.reduction import Reduction, reduce, solve_interior
from owt_structure_node.core.response import ModalModel, build_modal_model
from owt_wave_node.core.hydro_mesh import case_hydro_mesh
from owt_wave_node.core.loads import prepare_loads
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import build_sea_state

__all__ = ["CLUSTERED", "CLUSTERS", "PLAIN", "SPECIFIC", "SeaErrors", "cluster_of", "table_errors"]

#: Models of figure 6.2, of each sea state's own loads; those with load vectors are clustered in figure 6.3.
SPECIFIC = ("CB00", "CB20", "CB10M10", "M20")
CLUSTERED = ("CB10M10", "M20")
#: Clusters of table 6.2, and the last one without each sea state's loads made equally large first.
CLUSTERS, PLAIN = ("dir", "hs", "tot"), "tot, not normalised"
#: Load shapes of a sea state that are kept, that its error estimate knows, and of a cluster.
KEPT, ESTIMATED, SHARED = 60, 30, 20

Moments = dict[str, np.ndarray]


@dataclass(frozen=True)
class SeaErrors:
    """What one sea state gave.

    Attributes
    ----------
    mean, std : dict of float
        Relative errors of mean and standard deviation of the potential energy, by model ("M20 dir").
    estimate : dict of float
        Error of the mean that was to be expected from the loads alone, of the models of its own loads.
    pov : float array [shape]
        Share of the variance of the loads that each load shape carries.
    """

    mean: dict[str, float]
    std: dict[str, float]
    estimate: dict[str, float]
    pov: Float[np.ndarray, " shape"]


def cluster_of(cell: Cell, clustering: str) -> str:
    """Name of the cluster of a sea state: its direction, its 1 m bin of the wave height, or the only one."""
    if clustering == "dir":
        return f"dir {cell.from_deg:g}"
    return f"hs {int(cell.hs_m)}" if clustering == "hs" else clustering


class _Runs:
    """What all runs share."""

    def __init__(self, cells: Sequence[Cell], samples: int, store: Store) -> None:
        self.cells, self.samples, self.store = list(cells), samples, store
        case = cell_case(self.cells[0], samples=samples)
        self.mesh = build_mesh(case_structure(case.structure))
        self.damping, self.dt = case.structure.damping, case.time.dt_s
        self.hydro = case_hydro_mesh(case, self.mesh, lowest=-np.inf)
        self.node = self.hydro.node
        self.assembly = assemble(self.mesh)
        self.interior = solve_interior(self.assembly, 20)
        self.full = self.energies(build_modal_model(self.mesh, "full"))

    def energies(self, model: ModalModel) -> EnergyModel:
        return EnergyModel.of(model, self.node, self.damping, self.dt)

    def reduced(self, name: str, basis: LoadBasis) -> Reduction:
        return reduce(self.assembly, name, basis, interior=self.interior)

    def key(self, what: str, cell: Cell, seed: int) -> list[object]:
        case = cell_case(cell, seed=seed, samples=self.samples)
        return [
            what,
            self.mesh.structure.content_hash,
            case.model_dump(mode="json", exclude={"fatigue", "stream"}),
        ]

    def loads(self, cell: Cell, seed: int) -> Float[np.ndarray, "time load"]:
        """Nodal loads of a sea state, all components of a sample in a row."""
        case = cell_case(cell, seed=seed, samples=self.samples)
        sea = build_sea_state(case)
        windows = prepare_loads(case, self.mesh, sea, make_field(case, sea), hydro=self.hydro)
        nodal = replace(windows, keep_ends=False).window(0).nodal  # the records are of one window
        return np.ascontiguousarray(nodal.transpose(2, 0, 1)).reshape(self.samples, -1)

    def specific(self, cell: Cell, seed: int) -> Moments:
        """Energies of the unreduced model and of :data:`SPECIFIC`, estimates, and the sea's load shapes."""
        return self.store.run(self.key("specific", cell, seed), lambda: self._specific(cell, seed))

    def _specific(self, cell: Cell, seed: int) -> Moments:
        nodal = self.loads(cell, seed)
        by_node = nodal.reshape(len(nodal), -1, 6)
        basis = load_basis(by_node, self.node, KEPT, model_hash=self.mesh.structure.content_hash)
        found = {"full": _moments(self.full.potential(nodal))}
        errors = ErrorModel(self.assembly, _first(basis, ESTIMATED), damping=self.damping, dt=self.dt)
        for name in SPECIFIC:
            reduced = self.reduced(name, basis)
            found[name] = _moments(self.energies(_decoupled(self.assembly, reduced)).potential(nodal))
            found[f"estimate {name}"] = np.array(errors.energy_error(reduced))
        norm = np.sqrt(basis.total_variance)
        share = basis.singular_values / norm
        found["shapes"] = share[:, None] * basis.vectors.reshape(len(share), -1)
        return found | {"norm": np.array(norm), "pov": share**2}

    def cluster_basis(self, members: Sequence[Moments], *, normalised: bool = True) -> LoadBasis:
        """Load vectors of a cluster from the load shapes of its sea states."""

        def histories() -> Iterator[Float[np.ndarray, "snapshot loaded 6"]]:
            for kept in members:
                shapes = kept["shapes"] * (1.0 if normalised else kept["norm"])
                # Each shape with either sign: no mean, and the scatter matrix of the record.
                yield np.concatenate([shapes, -shapes]).reshape(-1, len(self.node), 6)

        parts = histories() if normalised else [np.concatenate(list(histories()))]
        return clustered_basis(parts, self.node, SHARED, model_hash=self.mesh.structure.content_hash)

    def cluster_models(self, first: Sequence[Moments]) -> dict[str, dict[str, EnergyModel]]:
        """Models of every cluster, by its name and theirs; `first` are the results of the first seed."""
        found = {}
        for clustering in CLUSTERS:
            label = [cluster_of(cell, clustering) for cell in self.cells]
            for name in dict.fromkeys(label):
                basis = self.cluster_basis(
                    [kept for kept, own in zip(first, label, strict=True) if own == name]
                )
                found[name] = self.served(clustering, basis)
        found[PLAIN] = self.served(PLAIN, self.cluster_basis(first, normalised=False))
        return found

    def served(self, clustering: str, basis: LoadBasis) -> dict[str, EnergyModel]:
        """Models of :data:`CLUSTERED` with the load vectors of a cluster."""
        return {
            f"{name} {clustering}": self.energies(_decoupled(self.assembly, self.reduced(name, basis)))
            for name in CLUSTERED
        }

    def clustered(self, cell: Cell, seed: int, models: dict[str, EnergyModel]) -> Moments:
        """Energies of the clustered models that serve a sea state."""
        made_of = [[c.hs_m, c.from_deg, c.tp_s] for c in self.cells]

        def compute() -> Moments:
            nodal = self.loads(cell, seed)
            return {name: _moments(model.potential(nodal)) for name, model in models.items()}

        return self.store.run([*self.key("clustered", cell, seed), made_of], compute)


def table_errors(
    cells: Sequence[Cell],
    others: dict[int, Sequence[Cell]],
    *,
    samples: int,
    store: Store,
    progress: Progress,
) -> dict[int, dict[Cell, SeaErrors]]:
    """Errors of all models in sea states of the load-case table, by seed.

    Parameters
    ----------
    cells : sequence of Cell
        Sea states of seed 1, of which the clusters are made.
    others : dict of sequences of Cell
        Sea states of further seeds, which no cluster has seen.
    samples : int
        Length of the records in load steps.
    store : Store
        Where runs are kept.
    progress : callable
        Called with the runs done and those in all.
    """
    runs = _Runs(cells, samples, store)
    asked = [(1, cell) for cell in cells] + [(seed, cell) for seed, some in others.items() for cell in some]
    done, kept = 0, {}
    for seed, cell in asked:
        kept[seed, cell] = runs.specific(cell, seed)
        if seed != 1:
            del kept[seed, cell]["shapes"]
        done += 1
        progress(done, 2 * len(asked))
    models = runs.cluster_models([kept[1, cell] for cell in cells])
    found: dict[int, dict[Cell, SeaErrors]] = {}
    for seed, cell in asked:
        serving: dict[str, EnergyModel] = {}
        for clustering in (*CLUSTERS, PLAIN):
            serving |= models[cluster_of(cell, clustering)]
        moments = kept[seed, cell] | runs.clustered(cell, seed, serving)
        found.setdefault(seed, {})[cell] = _errors(moments, [*SPECIFIC, *serving])
        done += 1
        progress(done, 2 * len(asked))
    return found


def _errors(found: Moments, names: Sequence[str]) -> SeaErrors:
    relative = {name: np.abs(found[name] / found["full"] - 1.0) for name in names}
    return SeaErrors(
        mean={name: float(error[0]) for name, error in relative.items()},
        std={name: float(error[1]) for name, error in relative.items()},
        estimate={name: float(found[f"estimate {name}"]) for name in SPECIFIC},
        pov=found["pov"],
    )


def _decoupled(assembly: Assembly, reduced: Reduction) -> ModalModel:
    """A reduced model in its own modes."""
    square, modes = dense_modes(reduced.stiffness, reduced.mass)
    amplitude = np.ascontiguousarray(modes.T)
    return ModalModel(
        assembly, reduced.name, square, reduced.shapes, amplitude, amplitude, reduced.coordinate_name
    )


def _first(basis: LoadBasis, count: int) -> LoadBasis:
    """The same loads by fewer shapes."""
    return replace(
        basis,
        vectors=basis.vectors[:count],
        singular_values=basis.singular_values[:count],
        spectrum=basis.spectrum[:count],
    )


def _moments(energy: Float[np.ndarray, " time"]) -> Float[np.ndarray, " 2"]:
    return np.array([energy.mean(), energy.std()])
