"""Thesis figures 4.4 and 4.5: error and time of three force distributions against the number of elements.

A member of 10 m, submerged or through the surface, in a second-order sea. Errors are the largest differences
of total force and of moment about the lower end, over the largest values; times those of kinematics and
loads.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float

from owt_campaign.studies.cases import SEEDS
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, number, rows_table, table
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
REPEATS = 5
TUBE = {
    "diameter_m": 1.2,
    "thickness_m": 0.05,
    "youngs_modulus_pa": 2.1e11,
    "shear_modulus_pa": 8.1e10,
    "density_kg_m3": 7850.0,
}


@dataclass(frozen=True)
class Found:
    """Errors of force and moment by seed, and least processor time in s, of a place, distribution, count."""

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
    since = time.process_time()
    nodal = assemble(asked, hydro, Frame(0.0), field, lowest=-5.0, highest=5.0).nodal
    seconds = time.process_time() - since
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
    """What the thesis' text says of its figures, each with the number that decides it; 10 elements."""
    rows = []
    for place in PLACES:
        linear, constant, quadratic = (
            np.array(found[place, name, 10].force) for name in ("linear", "constant", "quadratic")
        )
        ratio, same = quadratic / linear, constant / linear
        best, alike = "quadratic performs best", "the same level of accuracy"
        rows += [
            _accuracy(f"force error, quadratic over linear, {place}", best, ratio, ratio < 1.0),
            _accuracy(f"force error, constant over linear, {place}", alike, same, np.abs(same - 1.0) < 0.5),
        ]
    splash, deep = (found[place, "linear", 10] for place in PLACES)
    worst = np.array(splash.moment) / np.max([splash.force, deep.force, deep.moment], axis=0)
    largest = "maximum error: moment, splash zone"
    rows.append(_accuracy("moment error over the next largest, linear", largest, worst, worst > 1.0))
    submerged, surface = (
        found[place, "linear", 10].seconds / found[place, "constant", 10].seconds
        for place in ("submerged", "splash zone")
    )
    fast = submerged > 1.2
    return [
        *rows,
        _time("submerged", "constant takes the least, by far", submerged, fast),
        _time("splash zone", "difference less pronounced", surface, fast and 1.0 < surface < submerged),
    ]


def _accuracy(
    name: str, printed: str, ours: Float[np.ndarray, " seed"], agrees: Bool[np.ndarray, " seed"]
) -> Row:
    verdict: Outcome = "reproduced" if agrees.all() else "partly" if agrees.any() else "not"
    spread = (float(ours.min()), float(ours.max()))
    return Row(name, "4.2.3, figure 4.4", printed, float(ours.mean()), spread=spread, verdict=verdict)


def _time(place: str, printed: str, ours: float, agrees: bool) -> Row:
    name = f"time, linear over constant, {place}"
    return Row(name, "4.2.3, figure 4.5", printed, ours, verdict="reproduced" if agrees else "not")


def _figure(found: Table, counts: tuple[int, ...], time_: bool) -> Figure:
    from owt_campaign.studies.plotting import BLUE, GREEN, ORANGE, canvas, legend

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
    legend(panels[0, 0])
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


_HEAD = """\
Written by `./owt study interpolation --full -o docs/study`.

A tube of 10 m and diameter 1.2 m, inclined along the waves: through the surface (z from -5 to 3 m) or
submerged (-18 to -10 m), in a second-order sea of Hs 3 m, Tp 8 s with Taylor expansion above still water and
cut-off 4 omega_p, 600 s at 0.1 s, three seeds. The thesis names neither place nor sea of its member, and its
curves are lost; what is left of them is what its text says. Errors are the largest differences of total force
and of moment about the lower end from those of 200 quadratic elements, over the largest values. Times are
processor times of kinematics and loads together, the least of all repetitions."""

_ROWS = """\
## What the thesis says of the figures

Errors of the rows are means over the seeds."""

_ACCURACY = """\
## Figure 4.4: accuracy

![Errors of force and moment](interpolation-accuracy.png)

Constant and linear give the same total force: the sum of the trapezoidal rule either way. Their error falls
with the square of the element length, that of the quadratic distribution with its fourth power."""

_TIME = """\
## Figure 4.5: time

![Time of kinematics and loads](interpolation-time.png)"""

_VERDICT = Verdict(
    "partly",
    "Accuracy (figure 4.4) as the thesis describes it: quadratic best, constant and linear alike, the "
    "moment in the splash zone worst. Not the times (figure 4.5): here the integration is compiled and "
    "costs next to nothing beside the kinematics, so that constant is no faster than linear, submerged or "
    "not; for equal accuracy the quadratic distribution is the cheapest.",
)


def _result(found: Table, counts: tuple[int, ...], *, full: bool) -> StudyResult:
    rows = _rows(found)
    sections = [_HEAD, _ROWS, rows_table(rows), _ACCURACY, _TIME, _table(found, counts)]
    data = [
        {"place": place, "distribution": name, "elements": count, "force_error": entry.force,
         "moment_error": entry.moment, "time_s": entry.seconds}
        for (place, name, count), entry in found.items()
    ]  # fmt: skip
    return StudyResult(
        "interpolation",
        "Force between hydrodynamic nodes: thesis figures 4.4 and 4.5",
        sections,
        rows,
        _VERDICT,
        full=full,
        figures={
            "accuracy": lambda: _figure(found, counts, False),
            "time": lambda: _figure(found, counts, True),
        },
        data={"runs": data},
    )
