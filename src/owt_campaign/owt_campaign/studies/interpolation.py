"""Thesis figures 4.4 and 4.5: error and time of three force distributions against the number of elements.

A member of 10 m, submerged or through the surface, in a second-order sea. Errors are the largest differences of
total force and of moment about the lower end, over the largest values; times those of kinematics and loads.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import SEEDS
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import Row, StudyResult, number, table
from owt_model.config import CaseConfig, parse_case
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import parse_structure
from owt_wave_node.core.assembly import assemble
from owt_wave_node.core.field import Field
from owt_wave_node.core.hydro_mesh import build_hydro_mesh
from owt_wave_node.core.route import make_field
from owt_wave_node.core.sea import Frame, build_sea_state

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["COUNTS", "DISTRIBUTIONS", "PLACES", "Found", "compute", "run"]

COUNTS = (1, 2, 5, 10, 20, 50)
DISTRIBUTIONS = ("constant", "linear", "quadratic")
#: Ends of the member: 10 m long, inclined along the waves. The thesis does not say where its member stands.
PLACES = {
    "splash zone": ((0.0, 0.0, -5.0), (6.0, 0.0, 3.0)),
    "submerged": ((0.0, 0.0, -18.0), (6.0, 0.0, -10.0)),
}
SEA = {"hs_m": 3.0, "tp_s": 8.0, "direction_deg": 0.0}
#: Elements of the member that errors are measured from, quadratic.
FINEST = 200
#: Times are the least of so many.
REPEATS = 3
TUBE = {
    "diameter_m": 1.2,
    "thickness_m": 0.05,
    "youngs_modulus_pa": 2.1e11,
    "shear_modulus_pa": 8.1e10,
    "density_kg_m3": 7850.0,
}


@dataclass(frozen=True)
class Found:
    """Errors of force and moment, and least time in s, of one place, distribution and count; per seed."""

    force: list[float]
    moment: list[float]
    seconds: float


Table = dict[tuple[str, str, int], Found]


def member(foot: tuple[float, ...], head: tuple[float, ...]) -> Mesh:
    """One tube from `foot`, which is held, to `head`."""
    data = {
        "name": "member",
        "elements_per_member": 1,
        "mudline_z_m": -50.0,
        "sections": {"tube": TUBE},
        "joints": {"foot": list(foot), "head": list(head)},
        "members": {"m": {"joints": ["foot", "head"], "section": "tube"}},
        "supports": {"foot": [True] * 6},
        "interface": {"joints": ["head"], "reference_m": list(head)},
    }
    return build_mesh(parse_structure(data, source="study"))


def forces(
    case: CaseConfig, mesh: Mesh, field: Field, count: int, distribution: str
) -> tuple[Float[np.ndarray, "3 time"], Float[np.ndarray, "3 time"], float]:
    """Total force in N, moment about the lower end in N m, and the time in s that they took."""
    morison = case.morison.model_copy(update={"distribution": distribution})
    asked = case.model_copy(update={"morison": morison})
    hydro = build_hydro_mesh(mesh, water_depth=50.0, longest=10.0 / count, distribution=distribution)
    since = time.perf_counter()
    nodal = assemble(asked, hydro, Frame(0.0), field, lowest=-5.0, highest=5.0).nodal
    seconds = time.perf_counter() - since
    lever = np.cross(mesh.node_position[:2] - mesh.node_position[0], nodal[:, :3].transpose(2, 0, 1))
    return nodal[:, :3].sum(axis=0), nodal[:, 3:].sum(axis=0) + lever.sum(axis=1).T, seconds


def compute(counts: tuple[int, ...], seeds: tuple[int, ...], samples: int, progress: Progress) -> Table:
    """Errors and times of every place, distribution and count."""
    found: Table = {}
    steps, done = len(PLACES) * len(seeds), 0
    for place, ends in PLACES.items():
        mesh = member(*ends)
        for seed in seeds:
            case = parse_case({"sea_state": SEA | {"seed": seed}, "time": {"n": samples}})
            field = make_field(case, build_sea_state(case))
            exact = forces(case, mesh, field, FINEST, "quadratic")[:2]
            for distribution in DISTRIBUTIONS:
                for count in counts:
                    runs = [forces(case, mesh, field, count, distribution) for _ in range(REPEATS)]
                    entry = found.setdefault((place, distribution, count), Found([], [], np.inf))
                    off = [
                        float(np.abs(runs[0][i] - exact[i]).max() / np.abs(exact[i]).max()) for i in (0, 1)
                    ]
                    entry.force.append(off[0])
                    entry.moment.append(off[1])
                    least = min(entry.seconds, *(run[2] for run in runs))
                    found[place, distribution, count] = Found(entry.force, entry.moment, least)
            done += 1
            progress(done, steps)
    return found


def run(*, full: bool, progress: Progress) -> StudyResult:
    """The study: six counts, three seeds of 600 s; reduced: two counts, one seed of 60 s."""
    counts, seeds, samples = (COUNTS, SEEDS, 6000) if full else ((5, 10), SEEDS[:1], 600)
    return _result(compute(counts, seeds, samples, progress), counts, full=full)


def _rows(found: Table) -> list[Row]:
    def mean(place: str, name: str, what: str) -> float:
        return float(np.mean(getattr(found[place, name, 10], what)))

    def span(place: str, name: str, what: str) -> tuple[float, float]:
        values = getattr(found[place, name, 10], what)
        return min(values), max(values)

    rows = []
    for place in PLACES:
        ratio = mean(place, "quadratic", "force") / mean(place, "linear", "force")
        rows.append(
            Row(
                f"error of force, quadratic over linear, {place}, 10 elements",
                "4.2.3, figure 4.4",
                "quadratic performs best",
                ratio,
                verdict="reproduced" if ratio < 1.0 else "not",
            )
        )
        same = mean(place, "constant", "force") / mean(place, "linear", "force")
        rows.append(
            Row(
                f"error of force, constant over linear, {place}, 10 elements",
                "4.2.3, figure 4.4",
                "the same level of accuracy",
                same,
                verdict="reproduced" if 0.5 < same < 2.0 else "not",
            )
        )
    largest = max(PLACES, key=lambda place: mean(place, "linear", "moment"))
    moment_worst = mean("splash zone", "linear", "moment") > mean("splash zone", "linear", "force")
    rows.append(
        Row(
            "error of moment, linear, splash zone, 10 elements",
            "4.2.3, figure 4.4",
            "the largest error is that of the moment in the splash zone",
            mean("splash zone", "linear", "moment"),
            spread=span("splash zone", "linear", "moment"),
            verdict="reproduced" if largest == "splash zone" and moment_worst else "not",
        )
    )
    for place, statement in (
        ("submerged", "constant takes the least time, by far when submerged"),
        ("splash zone", "less pronounced in the splash zone"),
    ):
        seconds = {name: found[place, name, 10].seconds for name in DISTRIBUTIONS}
        ratio = seconds["linear"] / seconds["constant"]
        fast = ratio > 1.2 if place == "submerged" else ratio >= 1.0
        rows.append(
            Row(
                f"time, linear over constant, {place}, 10 elements",
                "4.2.3, figure 4.5",
                statement,
                ratio,
                verdict="reproduced" if fast else "not",
            )
        )
    return rows


def _figure(found: Table, counts: tuple[int, ...], time_: bool) -> Figure:
    from owt_campaign.studies.plotting import BLUE, GREEN, ORANGE, canvas

    style = {"constant": (ORANGE, "s", "-"), "linear": (BLUE, "o", "--"), "quadratic": (GREEN, "^", "-")}
    figure, panels = canvas(1, 2, (9.0, 3.6), share_y="row")
    for panel, place in zip(panels[0], PLACES, strict=True):
        for name, (colour, marker, line) in style.items():
            entries = [found[place, name, count] for count in counts]
            look: dict[str, Any] = {"color": colour, "marker": marker, "ls": line, "ms": 4}
            if time_:
                panel.loglog(counts, [1e3 * entry.seconds for entry in entries], label=name, **look)
                continue
            panel.loglog(counts, [np.mean(e.force) for e in entries], label=f"{name}, force", **look)
            look["alpha"] = 0.45
            panel.loglog(counts, [np.mean(e.moment) for e in entries], label=f"{name}, moment", **look)
        panel.set(title=place, xlabel="elements in 10 m", xticks=counts)
        panel.set_xticklabels([str(count) for count in counts])
        panel.minorticks_off()
    panels[0, 0].set_ylabel("time [ms]" if time_ else "largest error over the largest value")
    panels[0, 0].legend()
    return figure


def _table(found: Table, counts: tuple[int, ...]) -> str:
    head = ["place", "distribution", "elements", "force error", "moment error", "time [ms]"]
    lines = [
        [place, name, str(count), number(float(np.mean(entry.force))), number(float(np.mean(entry.moment))),
         number(1e3 * entry.seconds)]
        for place in PLACES
        for name in DISTRIBUTIONS
        for count in counts
        for entry in [found[place, name, count]]
    ]  # fmt: skip
    return table(head, lines)


def _result(found: Table, counts: tuple[int, ...], *, full: bool) -> StudyResult:
    print({k: (v.force, v.moment, v.seconds) for k, v in found.items()})
    raise SystemExit
