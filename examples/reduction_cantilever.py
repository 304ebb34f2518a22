"""Thesis figures 3.3 to 3.5: what vibration modes give a reduced model, and what load vectors give it.

The cantilever of figure 3.2, four elements in a plane, its right end the boundary; a force on the first free
node. Modes resolve the frequency of the response (spectral convergence), load vectors its shape (spatial).
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicHermiteSpline

from owt_model.mesh import build_mesh
from owt_model.pod import load_basis
from owt_model.structure import parse_structure
from owt_structure_node.core.assembly import Assembly, assemble
from owt_structure_node.core.reduction import reduce

H, HERTZ, LOSS, INK, GREY, BLUE = 10.0, 8.0, 0.01, "#1c2733", "#b9c3ce", "#1f5f99"
TUBE = {"diameter_m": 1.2, "thickness_m": 0.05, "youngs_modulus_pa": 2.1e11, "shear_modulus_pa": 8.1e10}
MODELS = {"CB00": (GREY, 4), "CB02": ("#c8602b", 1.8), "M01": ("#9fd0a6", 4), "CB02M01": (BLUE, 1.8)}


def cantilever() -> Assembly:
    joints = {name: [H * i, 0.0, 0.0] for i, name in enumerate("ABCDE")}
    plane = [False, True, False, True, False, True]
    data = {"name": "cantilever", "elements_per_member": 1, "mudline_z_m": -50.0, "joints": joints,
            "sections": {"tube": TUBE | {"density_kg_m3": 7850.0}},
            "members": {m: {"joints": list(m), "section": "tube"} for m in ("AB", "BC", "CD", "DE")},
            "supports": {"A": [True] * 6, "B": plane, "C": plane, "D": plane},
            "interface": {"joints": ["E"], "reference_m": joints["E"]}}  # fmt: skip
    return assemble(build_mesh(parse_structure(data, source="example")))


def response(assembly: Assembly, force: np.ndarray, hertz: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Complex amplitudes of the steady motion with a loss factor of 1 % [frequency, dof]."""
    stiffness, mass = (shapes.T @ (a @ shapes) for a in (assembly.stiffness, assembly.mass))
    dynamic = (1.0 + 1j * LOSS) * stiffness - (2.0 * np.pi * hertz[:, None, None]) ** 2 * mass
    return np.linalg.solve(dynamic, (shapes.T @ force)[:, None])[..., 0] @ shapes.T


def along_beam(assembly: Assembly, motion: np.ndarray) -> tuple[np.ndarray, ...]:
    """Place, displacements along and across, and slope, by the shape functions of the elements."""
    node, ends, place = (assembly.expansion @ motion).reshape(-1, 6), H * np.arange(5), np.linspace(0, 40, 81)
    across = CubicHermiteSpline(ends, node[:5, 2], -node[:5, 4])
    return place, np.interp(place, ends, node[:5, 0]), across(place), across.derivative()(place)


def ladder(panel, assembly: Assembly, motion: np.ndarray, title: str) -> None:
    """The beam with its cross-sections: bending bends it, stretch moves them apart."""
    place, along, across, slope = along_beam(assembly, motion)
    scale, half = 5.0 / max(np.abs(along).max(), np.abs(across).max()), np.array([[-1.5], [1.5]])
    x, z = place + scale * (along - half * slope), scale * across + half
    for every, colour in ((4, GREY), (20, INK)):
        panel.plot(x[:, ::every], z[:, ::every], color=colour, lw=1.2)
    panel.plot(x.T, z.T, color=BLUE, lw=1.5)
    panel.set(title=title, xlim=(-2, 48), ylim=(-7, 7), aspect="equal")
    panel.axis("off")


def main(folder: Path) -> None:
    assembly, hertz, found = cantilever(), np.append(np.geomspace(0.3, 30.0, 201), HERTZ), {}
    mesh, look = assembly.mesh, {"figsize": (11, 11), "layout": "constrained"}
    figure, panel = plt.subplot_mosaic("aabbcc;ddeeff;ggghhh;iiijjj", height_ratios=(1, 1, 1.8, 2.2), **look)
    for way, direction, shape, curve in (("across", 2, "g", "i"), ("along", 0, "h", "j")):
        nodal, part = np.zeros((2, mesh.n_nodes, 6)), 1 + direction // 2
        nodal[0, 1, direction] = 1.0
        load = load_basis(nodal, np.arange(mesh.n_nodes), 1, model_hash=mesh.structure.content_hash)
        force = assembly.expansion.T @ nodal[0].ravel()
        exact = response(assembly, force, hertz, np.eye(mesh.n_dof))
        for name, (colour, width) in MODELS.items():
            basis = reduce(assembly, name, load)
            motion = response(assembly, force, hertz, basis.shapes)
            missed, whole = (np.vecdot(u, u @ assembly.stiffness).real for u in (motion - exact, exact))
            error = np.sqrt(missed / whole)
            found[way, name], beam = error[-1], along_beam(assembly, motion[-1].real)
            panel[curve].loglog(hertz[:-1], error[:-1], color=colour, lw=width)
            panel[shape].plot(beam[0], beam[part], color=colour, lw=width, label=name)
        panel[shape].plot(beam[0], along_beam(assembly, exact[-1].real)[part], "k:", lw=3, label="full")
        panel[shape].set(title=f"force {way} at 10 m, {HERTZ:g} Hz: displacement", xlabel="m", yticks=[0])
        panel[curve].set(title=f"force {way}: error of the response", xlabel="Hz", ylim=(1e-5, 30))
    panel["g"].legend(frameon=False)
    own = np.sqrt([*basis.fixed_interface, *basis.pseudo]) / (2.0 * np.pi)
    titles = [f"constraint mode, {name}" for name in ("along", "across", "rotation")]
    names = ("vibration mode", "vibration mode", "load vector, force along")
    titles += [f"{name}, {f:.1f} Hz" for name, f in zip(names, own, strict=True)]
    for place, title, column in zip("abcdef", titles, (0, 2, 4, 6, 7, 8), strict=True):
        ladder(panel[place], assembly, basis.shapes[:, column], title)
    figure.savefig(folder / "reduction_cantilever.png", dpi=130)
    plt.close(figure)
    print(*(f"force {way}, {name}: off by {value:.1%}" for (way, name), value in found.items()), sep="\n")
    assert found["along", "CB02"] > 0.8 > 0.02 > found["along", "M01"]  # modes lack its shape
    assert found["across", "M01"] > 0.8 > 0.05 > found["across", "CB02M01"]  # a vector lacks the frequency


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
