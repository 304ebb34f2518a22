"""Energy per mode of CB10M10 and energy of the load vectors: thesis chapter 6.3, figures 6.4 and 6.5."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.energies import EnergyModel
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.sea_table import Cell, cell_case
from owt_campaign.studies.store import Store
from owt_model.mesh import Mesh, build_mesh
from owt_model.pod import load_basis
from owt_model.structure import case_structure
from owt_structure_node.core.response import build_modal_model
from owt_wave_node.core.loads import prepare_loads
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import build_sea_state

__all__ = ["READINGS", "SEAS", "ModalShares", "modal_contribution"]

#: Low, medium and high sea state of figure 6.4; all are those of direction 270 deg in table 4.5.
SEAS = {"low": Cell(0.75, 270.0, 6.34), "medium": Cell(4.25, 270.0, 9.25), "high": Cell(8.25, 270.0, 11.5)}
REDUCTION, VECTORS = "CB10M10", 10
#: Ways to read what the print calls the energy of a load vector.
READINGS = ("as printed", "mean kept", "forces only", "singular values")


@dataclass(frozen=True)
class ModalShares:
    """What one record gave.

    Attributes
    ----------
    mode : float array [mode]
        Mean potential energy of ten fixed-interface modes and ten augmentation vectors, over their sum.
    of_jacket : float
        That sum over the mean potential energy of all.
    pov : dict of float arrays [vector]
        Share of each load vector in the variance of the loads, by reading.
    """

    mode: Float[np.ndarray, " mode"]
    of_jacket: float
    pov: dict[str, Float[np.ndarray, " vector"]]

    @property
    def fixed_interface(self) -> float:
        """Share of the fixed-interface modes."""
        return float(self.mode[:VECTORS].sum())

    @property
    def first_vector(self) -> float:
        """Share of the augmentation vector that carries most."""
        return float(self.mode[VECTORS:].max())

    @property
    def effective_vectors(self) -> float:
        """How many augmentation vectors of equal energy would be as spread: inverse sum of squared shares."""
        share = self.mode[VECTORS:] / self.mode[VECTORS:].sum()
        return float(1.0 / (share**2).sum())


def modal_contribution(*, full: bool, progress: Progress) -> dict[str, list[ModalShares]]:
    """Run the sea states with several seeds; results by sea state."""
    seeds, samples = range(1, 11 if full else 4), 6000 if full else 1200
    mesh = build_mesh(case_structure(cell_case(SEAS["low"]).structure))
    found: dict[str, list[ModalShares]] = {}
    store = Store()
    for name, cell in SEAS.items():
        for seed in seeds:
            key = ["modal", mesh.structure.content_hash, cell.hs_m, cell.from_deg, cell.tp_s, seed, samples]
            record = store.run(key, partial(_shares, mesh, cell, seed, samples))
            pov = {reading: record[reading] for reading in READINGS}
            found.setdefault(name, []).append(ModalShares(record["mode"], float(record["of_jacket"]), pov))
            progress(sum(map(len, found.values())), len(SEAS) * len(seeds))
    return found


def _shares(mesh: Mesh, cell: Cell, seed: int, samples: int) -> dict[str, np.ndarray]:
    case = cell_case(cell, seed=seed, samples=samples, reduction=REDUCTION)
    sea = build_sea_state(case)
    windows = prepare_loads(case, mesh, sea, make_field(case, sea))
    history = replace(windows, keep_ends=False).window(0)  # the records are of one window
    nodal = np.ascontiguousarray(history.nodal.transpose(2, 0, 1))
    basis = load_basis(nodal, history.node, VECTORS, model_hash=mesh.structure.content_hash)
    model = build_modal_model(mesh, REDUCTION, basis)
    energy = EnergyModel.of(model, history.node, case.structure.damping, case.time.dt_s)
    flat = nodal.reshape(len(nodal), -1)
    motion = energy.motion(flat)
    inside = [i for i, part in enumerate(model.coordinate_name) if part.startswith(("CB.", "MTA."))]
    # Each function of the basis alone [eq. 6.1]: inside the jacket they are orthogonal in the stiffness.
    shapes = model.basis[:, inside]
    stiffness = np.einsum("df,df->f", shapes, model.assembly.stiffness @ shapes)
    mean = 0.5 * stiffness * ((motion.displacement @ energy.coordinate[:, inside]) ** 2).mean(axis=0)
    total = float((motion.displacement**2 @ (0.5 * model.omega_squared)).mean())
    return {"mode": mean / mean.sum(), "of_jacket": np.array(mean.sum() / total), **_povs(flat)}


def _povs(nodal: Float[np.ndarray, "time load"]) -> dict[str, Float[np.ndarray, " vector"]]:
    """Share of the leading vectors in the loads' energy, by reading."""
    centred = nodal - nodal.mean(axis=0)
    forces = centred.reshape(len(nodal), -1, 6)[:, :, :3].reshape(len(nodal), -1)
    found = {}
    for name, part in zip(READINGS, (centred, nodal, forces), strict=False):
        value = np.linalg.eigvalsh(part.T @ part)[::-1]
        found[name] = value[:VECTORS] / value.sum()
    root = np.sqrt(np.maximum(np.linalg.eigvalsh(centred.T @ centred)[::-1], 0.0))
    found[READINGS[3]] = root[:VECTORS] / root.sum()  # singular values instead of their squares
    return found
