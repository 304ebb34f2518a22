"""Thesis figures 4.4 and 4.5: error and time of three force distributions against the number of elements.

A member of 10 m, submerged or through the surface, in a second-order sea. Errors are the largest differences
of total force and of moment about the lower end, over the largest values; times those of kinematics and
loads.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
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
#: Ratios of times from which on one is by far the shorter, and shorter at all.
FASTER, NOISE = 1.2, 1.1
#: Error of the force at which costs are compared.
ACCURATE = 1e-3
#: Labels of the axis of times.
TICKS_MS = (1, 2, 5, 10, 20, 50)
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
    asked = [(distribution, count) for count in counts for distribution in DISTRIBUTIONS]
    for place, ends in PLACES.items():
        mesh = member(*ends)
        for seed in seeds:
            case = parse_case({"sea_state": SEA | {"seed": seed}, "time": {"n": samples}})
            field = make_field(case, build_sea_state(case))
            exact = forces(case, mesh, field, FINEST, "quadratic")[:2]
            for distribution, count in asked:
                run = forces(case, mesh, field, count, distribution)
                entry = found.setdefault((place, distribution, count), Found([], [], np.inf))
                off = [float(np.abs(run[i] - exact[i]).max() / np.abs(exact[i]).max()) for i in (0, 1)]
                entry.force.append(off[0])
                entry.moment.append(off[1])
            # In turns, after all have run once: no distribution is measured colder than another.
            for distribution, count in asked * REPEATS:
                seconds = forces(case, mesh, field, count, distribution)[2]
                entry = found[place, distribution, count]
                found[place, distribution, count] = replace(entry, seconds=min(entry.seconds, seconds))
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
    submerged, surface = _time_ratio(found, "submerged"), _time_ratio(found, "splash zone")
    clear: Outcome = "reproduced" if submerged > FASTER else "partly" if submerged > NOISE else "not"
    less: Outcome = "not" if not 1.0 < surface < submerged else clear
    return [
        *rows,
        _time("submerged", "constant takes the least, by far", submerged, clear),
        _time("splash zone", "difference less pronounced", surface, less),
    ]


def _time_ratio(found: Table, place: str) -> float:
    """Time of linear over constant, geometric mean of all counts."""
    ratio = [found[place, "linear", n].seconds / found[place, "constant", n].seconds for n in _counts(found)]
    return float(np.exp(np.mean(np.log(ratio))))


def _counts(found: Table) -> list[int]:
    return sorted({count for _, _, count in found})


def _accuracy(
    name: str, printed: str, ours: Float[np.ndarray, " seed"], agrees: Bool[np.ndarray, " seed"]
) -> Row:
    verdict: Outcome = "reproduced" if agrees.all() else "partly" if agrees.any() else "not"
    spread = (float(ours.min()), float(ours.max()))
    return Row(name, "4.2.3, figure 4.4", printed, float(ours.mean()), spread=spread, verdict=verdict)


def _time(place: str, printed: str, ours: float, verdict: Outcome) -> Row:
    name = f"time, linear over constant, {place}"
    return Row(name, "4.2.3, figure 4.5", printed, ours, verdict=verdict)


def _orders(found: Table) -> str:
    """Power of the element length with which the errors fall, at the finer end."""
    counts = _counts(found)
    first, last = next((n for n in counts if n >= 10 and n < counts[-1]), counts[0]), counts[-1]

    def order(place: str, name: str) -> float:
        errors = [np.mean(found[place, name, n].force) for n in (first, last)]
        return float(np.log(errors[0] / errors[1]) / np.log(last / first))

    words = "; ".join(
        f"{name} {order('splash zone', name):.1f} (splash zone), {order('submerged', name):.1f} (submerged)"
        for name in ("linear", "quadratic")
    )
    return f"From {first} to {last} elements the error falls with this power of the element length: {words}."


def _cheapest(found: Table, place: str) -> str:
    """Distribution that reaches :data:`ACCURATE` in the least time."""
    seconds = {
        key[1]: min(
            (e.seconds for k, e in found.items() if k[:2] == key[:2] and np.mean(e.force) < ACCURATE),
            default=np.inf,
        )
        for key in found
        if key[0] == place
    }
    best = min(seconds, key=lambda name: seconds[name])
    return best if np.isfinite(seconds[best]) else "none of those tried"


def _verdict(found: Table, rows: list[Row]) -> Verdict:
    """What the rows say of both figures."""
    accuracy, times = ([row for row in rows if figure in row.where] for figure in ("4.4", "4.5"))
    said = {True: "as the thesis describes it", False: "not in all as the thesis describes it"}
    kinds = {row.verdict for row in times}
    told = "as it describes them" if kinds == {"reproduced"} else "not as it describes them"
    if len(kinds) > 1 or kinds == {"partly"}:
        told = "partly as it describes them"
    right = all(row.verdict == "reproduced" for row in accuracy)
    submerged, surface = (float(row.ours) for row in times)
    why = (
        f"Accuracy (figure 4.4) {said[right]}: quadratic best, constant and linear alike, the moment in the "
        f"splash zone worst. The times (figure 4.5) are {told}: linear takes {submerged:.2f} times as long "
        f"as constant submerged and {surface:.2f} times in the splash zone; here the integration is compiled "
        f"and costs little beside the kinematics. To {ACCURATE:g} of the force the cheapest is "
        f"{_cheapest(found, 'splash zone')} in the splash zone and {_cheapest(found, 'submerged')} submerged."
    )
    outcomes = {row.verdict for row in rows}
    return Verdict("reproduced" if outcomes == {"reproduced"} else "partly", why)


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
        if time_:
            panel.set_yticks(TICKS_MS, [str(tick) for tick in TICKS_MS])
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
curves are lost; what is left of them is what its text says. The tube stands in 50 m of water and belongs to
no model of this package. Errors are the largest differences of total force and of moment about the lower end
from those of 200 quadratic elements, over the largest values. Times are processor times of kinematics and
loads together, the least of all repetitions, which take turns after all have run once."""

_ROWS = """\
## What the thesis says of the figures

Errors of the rows are means over the seeds, with 10 elements; a statement on them is *reproduced* if every
seed has it, *partly* if some have (*the same level*: within a half). Ratios of times are geometric means over
all numbers of elements; *by far* is a fifth more, *partly* a tenth, since times differ from run to run."""

_ACCURACY = """\
## Figure 4.4: accuracy

![Errors of force and moment](interpolation-accuracy.png)

Constant and linear give the same total force: the sum of the trapezoidal rule either way."""

_TIME = """\
## Figure 4.5: time

![Time of kinematics and loads](interpolation-time.png)"""


def _result(found: Table, counts: tuple[int, ...], *, full: bool) -> StudyResult:
    rows = _rows(found)
    sections = [_HEAD, _ROWS, rows_table(rows), f"{_ACCURACY} {_orders(found)}", _TIME, _table(found, counts)]
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
        _verdict(found, rows),
        full=full,
        figures={
            "accuracy": lambda: _figure(found, counts, False),
            "time": lambda: _figure(found, counts, True),
        },
        data={"runs": data},
        structure="one tube of 10 m, named on this page",
    )
