"""The study of the load vectors that steep waves need, as a page: thesis 7.3.2."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from owt_campaign.studies.load_vectors import BASES, SHARES, TOLERANCES, WAVES, Need, period
from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, rows_table, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["load_vectors_result"]

Needs = dict[tuple[str, float, int], Need]

_HEAD = """\
Written by `./owt study load-vectors --full -o docs/study`; model `oc4-thesis`, waves towards 210 degrees.

Thesis 7.3.2 expects of regular and extreme waves that the trend of figure 6.5 goes on: "the larger the wave
height, the more MTAs are required". Of each wave the nodal loads are decomposed; counted are the vectors that
carry 99 and 99.9 % of their variance, and the vectors with which mean and standard deviation of the potential
energy come within 1e-3 and 1e-4 of the unreduced model's, beside ten fixed-interface modes (CB10Mnn) or
without (Mnn). Tried are 0 to 30 vectors.

- *stream function*: regular wave of height H and the shortest period that goes with it, T = 11.1 sqrt(H/g)
  (IEC 61400-3-1), ten periods; loads exact up to the surface.
- *stream function, one period*: all heights with the period of the highest, 14.6 s.
- *NewWave*: a second-order group (Taylor expansion, cut-off 4 omega_p) whose linear crest is H/2, in 80 s of
  calm.
- *irregular*: second-order sea of 300 s, Tp = T, of which H is the highest wave of about a thousand
  (Hs = H/1.86); three seeds, mean and range."""

_FIGURE = """\
![Vectors needed by wave height](load-vectors-need.png)"""


def load_vectors_result(found: Needs, *, full: bool) -> StudyResult:
    """Page, rows, figure and verdict from the needs of all waves."""
    rows = _rows(found)
    sections = [
        _HEAD,
        "## Does the need grow with the height\n\n" + rows_table(rows),
        "## Vectors needed\n\n" + _FIGURE,
        _table(found),
    ]
    data = [
        {
            "wave": wave,
            "height_m": height,
            "seed": seed,
            "first_share": float(f"{need.first:.4g}"),
            "by_share": {str(share): count for share, count in need.by_share.items()},
            "by_energy": {f"{base}nn {tolerance:g}": n for (base, tolerance), n in need.by_energy.items()},
        }
        for (wave, height, seed), need in found.items()
    ]
    return StudyResult(
        "load-vectors",
        "Load vectors that steep waves need: thesis 7.3.2",
        sections,
        rows,
        _verdict(found),
        full=full,
        figures={"need": lambda: _figure(found)},
        data={"needs": data},
    )


def _needs(found: Needs, wave: str, height: float) -> list[Need]:
    return [need for (w, h, _), need in found.items() if (w, h) == (wave, height)]


def _heights(found: Needs, wave: str) -> list[float]:
    return sorted({height for w, height, _ in found if w == wave})


def _counts(found: Needs, wave: str, what: float | tuple[str, float]) -> list[list[int]]:
    """Vectors needed at each height, for every seed; one more than were tried where those do not do."""
    rows = []
    for height in _heights(found, wave):
        needed = [
            need.by_energy[what] if isinstance(what, tuple) else need.by_share[what]
            for need in _needs(found, wave, height)
        ]
        rows.append([31 if n is None else n for n in needed])
    return rows


def _rows(found: Needs) -> list[Row]:
    rows = []
    for wave in dict.fromkeys(w for w, _, _ in found):
        for label, what in (
            ("carry 99.9 % of the load's variance", SHARES[-1]),
            (f"give the energy to {TOLERANCES[-1]:g}, CB10Mnn", (BASES[0], TOLERANCES[-1])),
        ):
            counts = _counts(found, wave, what)
            low, high = float(np.mean(counts[0])), float(np.mean(counts[-1]))
            verdict: Outcome = "reproduced" if high > 1.2 * low else "partly" if high > low else "not"
            heights = _heights(found, wave)
            spread = (min(counts[-1]), max(counts[-1])) if len(counts[-1]) > 1 else None
            rows.append(
                Row(
                    f"{wave}: vectors that {label}, H {heights[0]:g} and {heights[-1]:g} m",
                    "7.3.2",
                    "the larger the height, the more",
                    f"{low:.3g} and {high:.3g}",
                    spread=spread,
                    verdict=verdict,
                )
            )
    return rows


def _table(found: Needs) -> str:
    head = ["wave", "H [m]", "T or Tp [s]", "first vector [%]", "99 %", "99.9 %"]
    head += [f"{base}nn, {tolerance:g}" for base in BASES for tolerance in TOLERANCES]
    lines = []
    for wave in dict.fromkeys(w for w, _, _ in found):
        for height in _heights(found, wave):
            needed = _needs(found, wave, height)
            t = period(17.0 if wave == WAVES[1] else height)
            line = [wave, f"{height:g}", f"{t:.1f}", f"{100.0 * np.mean([n.first for n in needed]):.0f}"]
            line += [_span([n.by_share[share] for n in needed]) for share in SHARES]
            line += [
                _span([n.by_energy[base, tolerance] for n in needed])
                for base in BASES
                for tolerance in TOLERANCES
            ]
            lines.append(line)
    return table(head, lines)


def _span(counts: list[int] | list[int | None] | list[int]) -> str:
    """One count, or lowest to highest of several; more than 30 where those tried do not do."""
    named = [31 if n is None else n for n in counts]
    words = [">30" if n == 31 else str(n) for n in (min(named), max(named))]
    return words[0] if words[0] == words[1] else f"{words[0]} to {words[1]}"


def _verdict(found: Needs) -> Verdict:
    share, energy = SHARES[-1], (BASES[0], TOLERANCES[-1])
    waves = list(dict.fromkeys(w for w, _, _ in found))
    loads = [_ends(_counts(found, wave, share)) for wave in waves]
    response = [_ends(_counts(found, wave, energy)) for wave in waves]
    grown = [sum(high > low for low, high in ends) for ends in (loads, response)]
    heights = _heights(found, waves[0])

    def listed(ends: list[tuple[float, float]]) -> str:
        return "; ".join(f"{w}: {low:.3g} and {high:.3g}" for w, (low, high) in zip(waves, ends, strict=True))

    why = (
        f"From H {heights[0]:g} to {heights[-1]:g} m the vectors that carry 99.9 % of the variance of the "
        f"loads grow for {grown[0]} of {len(waves)} kinds of wave ({listed(loads)}), as the thesis "
        f"expects; those that bring the potential energy of CB10Mnn to {TOLERANCES[-1]:g} grow for "
        f"{grown[1]} ({listed(response)}). An irregular sea needs more of them than a regular wave or a "
        "group of its highest wave, so that a basis for the sea states serves those too."
    )
    outcome: Outcome = (
        "reproduced" if sum(grown) == 2 * len(waves) else "partly" if grown[0] > len(waves) / 2 else "not"
    )
    return Verdict(outcome, why)


def _ends(counts: list[list[int]]) -> tuple[float, float]:
    """Means of the lowest and of the highest wave."""
    return float(np.mean(counts[0])), float(np.mean(counts[-1]))


def _figure(found: Needs) -> Figure:
    from owt_campaign.studies.plotting import COLOURS, canvas, legend

    figure, panels = canvas(1, 2, (9.0, 3.6))
    shown: tuple[tuple[str, float | tuple[str, float]], ...] = (
        ("99.9 % of the load's variance", SHARES[-1]),
        (f"potential energy to {TOLERANCES[-1]:g}, CB10Mnn", (BASES[0], TOLERANCES[-1])),
    )
    for panel, (title, what) in zip(panels[0], shown, strict=True):
        for colour, wave in zip(COLOURS, dict.fromkeys(w for w, _, _ in found), strict=False):
            counts = _counts(found, wave, what)
            x = _heights(found, wave)
            panel.plot(x, [np.mean(n) for n in counts], color=colour, marker="o", ms=3.5, label=wave)
            panel.fill_between(x, [min(n) for n in counts], [max(n) for n in counts], color=colour, alpha=0.2)
        panel.set(title=title, xlabel="wave height H [m]", ylim=(0.0, None))
    panels[0, 0].set_ylabel("load vectors needed")
    legend(panels[0, 1], loc="upper right")
    return figure
