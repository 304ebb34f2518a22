"""The study of the load vectors that steep waves need, as a page: thesis 7.3.2."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from owt_campaign.studies.load_vectors import BASES, COUNTS, SHARES, TOLERANCES, WAVES, Need, enough, period
from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, rows_table, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["load_vectors_result"]

Needs = dict[tuple[str, float, int], Need]

#: Errors of a wave with the vectors of the irregular sea, by their number.
Borrowed = dict[tuple[str, float], dict[int, float]]

_TRIED = f"{', '.join(str(count) for count in COUNTS[:-1])} and {COUNTS[-1]}"

_HEAD = f"""\
Written by `./owt study load-vectors --full -o docs/study`; model `oc4-thesis`, waves towards 210 degrees.

Thesis 7.3.2 expects of regular and extreme waves that the trend of figure 6.5 goes on: "the larger the wave
height, the more MTAs are required". Of each wave the nodal loads are decomposed; counted are the vectors that
carry 99 and 99.9 % of their variance, and the vectors with which mean and standard deviation of the potential
energy come within 1e-3 and 1e-4 of the unreduced model's, beside ten fixed-interface modes (CB10Mnn) or
without (Mnn). Tried are {_TRIED} vectors; a wave needs the smallest
of these counts that meets the tolerance and whose larger ones meet it too (">{COUNTS[-1]}" where not even the
last does).

- *stream function*: regular wave of height H and the shortest period that goes with it, T = 11.1 sqrt(H/g)
  (IEC 61400-3-1), ten periods; loads exact up to the surface.
- *stream function, one period*: all heights with the period of the highest, 14.6 s.
- *NewWave*: a second-order group (Taylor expansion, cut-off 4 omega_p) whose linear crest is H/2, in 80 s of
  calm.
- *irregular*: second-order sea of 300 s, Tp = T, of which H is the highest wave of about a thousand
  (Hs = H/1.86), Taylor expansion, cut-off 4 omega_p; three seeds, mean and range.

No linear waves are run.

A row is *reproduced* if the highest wave needs more than 1.2 times as many vectors as the lowest, *partly* if
it needs more at all, else *not*; more than {COUNTS[-1]} count as {COUNTS[-1] + 1}."""

_FIGURE = """\
![Vectors needed by wave height](load-vectors-need.png)"""

_BORROWED = f"""\
## Vectors of the irregular sea for the other waves

CB10Mnn with the vectors of the irregular sea of the same H and T (seed 1): how many a wave needs for
{TOLERANCES[-1]:g}, of its own and of the sea, and the larger error of mean and standard deviation of the
potential energy with its own vectors / with those of the sea."""


def load_vectors_result(found: Needs, others: Borrowed, *, full: bool) -> StudyResult:
    """Page, rows, figure and verdict from the needs of all waves."""
    rows = [*_rows(found), _borrowed_row(others)]
    sections = [
        _HEAD,
        "## Does the need grow with the height\n\n" + rows_table(rows),
        "## Vectors needed\n\n" + _FIGURE,
        _table(found),
        _BORROWED,
        _borrowed_table(found, others),
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
        _verdict(found, others),
        full=full,
        figures={"need": lambda: _figure(found)},
        data={
            "needs": data,
            "borrowed": [
                {
                    "wave": wave,
                    "height_m": height,
                    "error": {str(n): float(f"{e:.3g}") for n, e in of.items()},
                }
                for (wave, height), of in others.items()
            ],
        },
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
            rows.append(
                Row(
                    f"{wave}: vectors that {label}, H {heights[0]:g} and {heights[-1]:g} m",
                    "7.3.2",
                    "the larger the height, the more",
                    f"{_mean(counts[0])} and {_mean(counts[-1])}",
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


def _mean(counts: list[int]) -> str:
    """Mean of the seeds and their range."""
    if len(set(counts)) == 1:
        return _span(counts)
    return f"{np.mean(counts):.3g} ({_span(counts)})"


def _serves(others: Borrowed) -> int:
    """Waves whose energy comes within the tolerance with vectors of the irregular sea."""
    return sum(enough(error, TOLERANCES[-1]) is not None for error in others.values())


def _borrowed_row(others: Borrowed) -> Row:
    heights = " and ".join(f"{h:g}" for h in dict.fromkeys(h for _, h in others))
    return Row(
        f"regular waves and groups of H {heights} m whose energy comes "
        f"within {TOLERANCES[-1]:g} with vectors of the irregular sea, CB10Mnn",
        "7.3.2",
        None,
        f"{_serves(others)} of {len(others)}",
    )


def _borrowed_table(found: Needs, others: Borrowed) -> str:
    """Errors with own vectors and with those of the sea."""
    shown = [count for count in COUNTS if count in (6, 10, 20, COUNTS[-1])]
    lines = []
    for (wave, height), error in others.items():
        own = _needs(found, wave, height)[0]
        line = [wave, f"{height:g}", _span([own.by_energy[BASES[0], TOLERANCES[-1]]])]
        line += [_span([enough(error, TOLERANCES[-1])])]
        lines.append(line + [f"{own.error[n]:.1e} / {error[n]:.1e}" for n in shown])
    return table(["wave", "H [m]", "own", "of the sea", *(f"error, {n} vectors" for n in shown)], lines)


def _span(counts: list[int] | list[int | None] | list[int]) -> str:
    """One count, or lowest to highest of several; more than 30 where those tried do not do."""
    named = [31 if n is None else n for n in counts]
    words = [">30" if n == 31 else str(n) for n in (min(named), max(named))]
    return words[0] if words[0] == words[1] else f"{words[0]} to {words[1]}"


def _verdict(found: Needs, others: Borrowed) -> Verdict:
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
        f"{grown[1]} ({listed(response)}). {_borrowed_words(others)}"
    )
    outcome: Outcome = (
        "reproduced" if sum(grown) == 2 * len(waves) else "partly" if grown[0] > len(waves) / 2 else "not"
    )
    return Verdict(outcome, why)


def _borrowed_words(others: Borrowed) -> str:
    """Whether a basis of the irregular sea serves the other waves."""
    serves, last = _serves(others), COUNTS[-1]
    worst = max(error[last] for error in others.values())
    return (
        f"Vectors of the irregular sea of the same height serve {serves} of {len(others)} regular waves and "
        f"groups to {TOLERANCES[-1]:g}; with {last} of them the energy is off by up to {worst:.1e}: "
        + (
            "they do for those too."
            if serves == len(others)
            else "they do not replace a wave's own at that tolerance."
        )
    )


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
