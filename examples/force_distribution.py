"""Thesis figures 4.4 and 4.5: error and time against the number of elements, three force distributions.

A member of 10 m, submerged or through the surface, in one second-order sea of 600 s at 0.1 s. Errors are the
largest differences of force and moment (about the lower end) over the largest values; times are those of
kinematics and loads of the member. Here loads
are compiled: what costs is the number of stations, not the integration of the force.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import parse_structure
from owt_wave_node.core.assembly import assemble
from owt_wave_node.core.hydro_mesh import build_hydro_mesh
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state

COUNTS = (1, 2, 5, 10, 20, 50)
STYLE = {"constant": ("#c8602b", "s"), "linear": ("#1f5f99", "o"), "quadratic": ("#3a7d44", "^")}
TUBE = {"diameter_m": 1.2, "thickness_m": 0.05, "youngs_modulus_pa": 2.1e11, "shear_modulus_pa": 8.1e10}


def member(foot: tuple[float, float, float], head: tuple[float, float, float]):
    data = {
        "name": "member", "elements_per_member": 1, "mudline_z_m": -50.0,
        "sections": {"tube": TUBE | {"density_kg_m3": 7850.0}},
        "joints": {"foot": list(foot), "head": list(head)},
        "members": {"m": {"joints": ["foot", "head"], "section": "tube"}}, "supports": {"foot": [True] * 6},
        "interface": {"joints": ["head"], "reference_m": list(head)},
    }  # fmt: skip
    return build_mesh(parse_structure(data, source="example"))


def main(folder: Path) -> None:
    members = {
        "splash zone": member((0.0, 0.0, -5.0), (6.0, 0.0, 3.0)),
        "submerged": member((0.0, 0.0, -18.0), (6.0, 0.0, -10.0)),
    }
    sea = {"hs_m": 3.0, "tp_s": 8.0, "seed": 4, "direction_deg": 0.0}
    figure, panels = plt.subplots(2, 2, figsize=(10, 7), layout="constrained", sharex=True)
    found: dict[tuple[str, str], tuple[list[float], list[float]]] = {}
    for column, (place, mesh) in enumerate(members.items()):
        case = parse_case({"sea_state": sea})
        field, frame = make_field(case, build_sea_state(case)), Frame(0.0)

        def loads(count: int, distribution: str, case=case, mesh=mesh, field=field, frame=frame):
            asked = case.model_copy(
                update={"morison": case.morison.model_copy(update={"distribution": distribution})}
            )
            hydro = build_hydro_mesh(mesh, water_depth=50.0, longest=10.0 / count, distribution=distribution)
            best = np.inf
            for _ in range(5):
                since = time.perf_counter()
                nodal = assemble(asked, hydro, frame, field, lowest=-5.0, highest=5.0).nodal
                best = min(best, time.perf_counter() - since)
            lever = np.cross(mesh.node_position[:2] - mesh.node_position[0], nodal[:, :3].transpose(2, 0, 1))
            moment = nodal[:, 3:].sum(axis=0) + lever.sum(axis=1).T
            return nodal[:, :3].sum(axis=0), moment, best

        exact = loads(200, "quadratic")[:2]
        for distribution, (colour, marker) in STYLE.items():
            runs = [loads(count, distribution) for count in COUNTS]
            error = [
                [float(np.abs(run[i] - exact[i]).max() / np.abs(exact[i]).max()) for run in runs]
                for i in (0, 1)
            ]
            found[place, distribution] = error[0], [run[2] for run in runs]
            style = {"color": colour, "marker": marker, "ms": 5, "ls": "--" if marker == "o" else "-"}
            panels[0, column].loglog(COUNTS, error[0], label=f"{distribution}, force", **style)
            panels[0, column].loglog(COUNTS, error[1], label=f"{distribution}, moment", alpha=0.45, **style)
            panels[1, column].loglog(COUNTS, [1e3 * s for s in found[place, distribution][1]], **style)
        panels[0, column].set(title=f"{place}: largest error over the largest value")
        panels[1, column].set(title=f"{place}: time (ms)", xlabel="elements in 10 m", xticks=COUNTS)
        panels[1, column].set_xticklabels(map(str, COUNTS))
        panels[1, column].set_yticks([1, 2, 5, 10, 20, 50], labels=["1", "2", "5", "10", "20", "50"])
        panels[1, column].minorticks_off()
    for panel in panels.flat:
        panel.grid(color="#e3e7eb", which="major")
        panel.spines[["top", "right"]].set_visible(False)
    panels[0, 0].legend(frameon=False, fontsize=8)
    figure.savefig(folder / "force_distribution.png", dpi=130)
    plt.close(figure)

    for place in members:
        at = COUNTS.index(10)
        linear, quadratic = (found[place, name][0][at] for name in ("linear", "quadratic"))
        print(f"{place}: with 10 elements linear is off by {linear:.1e}, quadratic by {quadratic:.1e}")
        assert quadratic < 0.05 * linear < 1e-3


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]))
