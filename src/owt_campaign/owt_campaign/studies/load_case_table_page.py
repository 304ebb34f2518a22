"""The study of the weighted Tp as a page: tables D.1 and D.2, by wave model and by period."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from owt_campaign.studies.cases import LINEAR, SECOND_ORDER, WAVE_MODELS
from owt_campaign.studies.load_case_table import (
    HIGH,
    LOW,
    RATIOS,
    STEEP_CUTOFF,
    TABLE_CUTOFF,
    Periods,
    Stresses,
    increases,
    printed,
)
from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, agreement, rows_table, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["load_case_table_result"]

#: First mode of each table's structure.
FREQUENCY = {"D.1": "0.38 Hz", "D.2": "0.28 Hz"}
#: The other linear model that the rows have.
WHEELER = "linear, Wheeler"

_HEAD = """\
Written by `./owt study load-case-table --full -o docs/study`; model `oc4-thesis` (table D.1, first mode at
0.38 Hz) and its frequency model (table D.2, 0.28 Hz).

Waves from 330 degrees. *ref* is the one sea state of the weighted Tp (9.06 s and 13.50 s), *spec* every Tp
that occurs in table 4.4 (20 of Hs 1.5 m, 5 of Hs 7.5 m), weighted by its occurrences. Compared is the mean
of the total stress (sum of range times count of the von Mises stress, 600 s) over all member ends; the thesis
says over all members, and on the page of the [wave comparison](wave-comparison.md) the worse end of a member
stands for it. Three seeds; each period has phases of its own, L and NL share them. NL: second order with
Taylor expansion. L: linear with constant extrapolation above still water, which the thesis does not state;
the others are below. Cut-off 4 omega_p (table 4.3) unless another one is named. One basis (CB20M30) serves
all runs: its mean total stress lies within 3e-4 of the unreduced model's.

The print calls its values increases and writes 96 % beside L_ref/L_spec; its text has the reference case
"produce a higher total stress" in both bins, so that they are taken as ratio less one. (As plain ratios 96 %
and 98 % would lie near ours, but not the 5.5 % and 143 % beside them.)

A value is *reproduced* if the print lies within the seeds, *partly* if it has the sign of the print and comes
within a factor of two of it, else *not*."""

_WHY = """\
## What the weighted Tp hides

![Total stress by period](load-case-table-periods.png)

Total stress of each specific Tp over that of the weighted one (second order, mean of the seeds); bars are the
occurrences, the dotted line is the weighted Tp. Short waves lie nearer to the first modes."""

_MODELS = """\
## The other linear models, and the other cut-off

NL_ref/L_ref and NL_spec/L_spec, less one, in percent, table D.1: mean over the seeds, lowest to highest."""

_CONTRARY = """\
Which of them the thesis had does not follow: the kinetic energy of figure 5.4 is nearest to the print with
another one than Wheeler's, which lies farthest from it ([wave comparison](wave-comparison.md))."""


def load_case_table_result(stresses: Stresses, periods: Periods, *, full: bool) -> StudyResult:
    """Page, rows, figure and verdict from mean stresses (:func:`~.load_case_table.compute`)."""
    rows = _rows(stresses)
    sections = [_HEAD, "## Tables D.1 and D.2\n\n" + rows_table(rows), _MODELS, _variants(stresses)]
    sections += [_CONTRARY, f"{_WHY} {_fall(stresses, periods)}"]
    data = {
        "mean_total_stress_pa": [
            {"table": key[0], "hs_m": key[1], "wave": key[2], "cutoff": key[3], "seed": key[4], **value}
            for key, value in stresses.items()
        ]
    }
    return StudyResult(
        "load-case-table",
        "Weighted against specific peak periods: thesis appendix D, tables D.1 and D.2",
        sections,
        rows,
        _verdict(stresses, rows),
        full=full,
        figures={"periods": lambda: _figure(stresses, periods)},
        data=data,
    )


def _by_seed(
    stresses: Stresses, table_: str, hs: float, linear: str = LINEAR, cutoff: str = TABLE_CUTOFF
) -> list[dict[str, float]]:
    """The four increases of every seed that both wave models have."""
    seeds = sorted({key[4] for key in stresses if key[:4] == (table_, hs, linear, cutoff)})
    return [
        increases(stresses[table_, hs, linear, cutoff, s], stresses[table_, hs, SECOND_ORDER, cutoff, s])
        for s in seeds
        if (table_, hs, SECOND_ORDER, cutoff, s) in stresses
    ]


def _rows(stresses: Stresses) -> list[Row]:
    """Every printed value; then those of the wave models again with Wheeler's linear one, table D.1."""
    heights = [hs for hs in (LOW, HIGH) if any(key[1] == hs for key in stresses)]
    tables = [name for name in ("D.1", "D.2") if any(key[0] == name for key in stresses)]
    asked = [(name, ratio, hs, LINEAR) for name in tables for ratio in RATIOS for hs in heights]
    asked += [("D.1", ratio, hs, WHEELER) for ratio in list(RATIOS)[2:] for hs in heights]
    rows = []
    for name, ratio, hs, linear in asked:
        values = [100.0 * found[ratio] for found in _by_seed(stresses, name, hs, linear)]
        if not values:
            continue
        print_ = 100.0 * printed()[name][ratio][f"{hs:g}"]
        ours, spread = float(np.mean(values)), (min(values), max(values))
        rows.append(
            Row(
                f"{ratio} - 1, Hs {hs:g} m" + ("" if linear == LINEAR else f", L {linear}"),
                f"table {name}",
                print_,
                ours,
                "%",
                spread if len(values) > 1 else None,
                _verdict_of(print_, ours, spread),
            )
        )
    return rows


def _verdict_of(print_: float, ours: float, spread: tuple[float, float]) -> Outcome:
    """Reproduced: within the seeds; partly: same sign, and within a factor of two."""
    if spread[0] <= print_ <= spread[1]:
        return "reproduced"
    return "not" if agreement(ours, print_) == "not" else "partly"


def _variants(stresses: Stresses) -> str:
    """What the ratio of the wave models becomes with other linear models and with the other cut-off."""
    lines = []
    for cutoff in (TABLE_CUTOFF, STEEP_CUTOFF):
        for wave in WAVE_MODELS:
            for hs in (LOW, HIGH):
                found = [] if wave == SECOND_ORDER else _by_seed(stresses, "D.1", hs, wave, cutoff)
                if found:
                    lines.append(
                        [wave, cutoff, f"{hs:g}", str(len(found))]
                        + [_span([f[ratio] for f in found]) for ratio in ("NL_ref/L_ref", "NL_spec/L_spec")]
                        + [f"{100.0 * printed()['D.1'][r][f'{hs:g}']:.2g}" for r in list(RATIOS)[2:]]
                    )
    head = ["linear model", "cut-off", "Hs [m]", "seeds", "ref", "spec", "print, ref", "print, spec"]
    return table(head, lines)


def _span(values: list[float]) -> str:
    percent = 100.0 * np.array(values)
    if len(percent) == 1:
        return f"{percent[0]:.2g}"
    return f"{percent.mean():.2g} ({percent.min():.2g} to {percent.max():.2g})"


def _by_period(stresses: Stresses, periods: Periods) -> dict[tuple[str, float], dict[float, float]]:
    """Total stress of each specific Tp over the weighted one's, by table and height, mean of the seeds."""
    found: dict[tuple[str, float], dict[float, list[float]]] = {}
    for (name, hs, wave, seed, tp), stress in periods.items():
        if wave == SECOND_ORDER:
            ref = stresses[name, hs, SECOND_ORDER, TABLE_CUTOFF, seed]["ref"]
            found.setdefault((name, hs), {}).setdefault(tp, []).append(stress / ref)
    return {
        key: {tp: float(np.mean(of[tp])) for tp in sorted(of)}
        for key, of in sorted(found.items(), key=lambda item: (item[0][1], item[0][0]))
    }


def _fall(stresses: Stresses, periods: Periods) -> str:
    """How the total stress falls with Tp, and where it does not."""
    every = _by_period(stresses, periods)
    rises = [
        f"{FREQUENCY[name]} at Hs {hs:g} m, where it rises from {before[1]:.2f} at {before[0]:g} s to "
        f"{after[1]:.2f} at {after[0]:g} s"
        for (name, hs), of in every.items()
        for before, after in pairwise(of.items())
        if after[1] > before[1]
    ]
    ends = "; ".join(
        f"{FREQUENCY[name]}, Hs {hs:g} m: {first:.2f} to {last:.2f}"
        for (name, hs), of in every.items()
        for first, last in [(next(iter(of.values())), list(of.values())[-1])]
    )
    but = f" but for {', '.join(rises)}" if rises else ""
    return f"The total stress falls with Tp{but}. From the shortest to the longest: {ends}."


def _counted(rows: list[Row]) -> str:
    """How many rows came to what."""
    seen = {what: sum(row.verdict == what for row in rows) for what in ("reproduced", "partly", "not")}
    other = sum(float(row.ours) * float(row.printed or 0.0) < 0.0 for row in rows)
    return (
        f"of {len(rows)} values {seen['reproduced']} within the seeds, {seen['partly']} within a factor of "
        f"two, {seen['not']} neither ({other} of all with the other sign)"
    )


def _outcome(rows: list[Row]) -> Outcome:
    """Of several rows together."""
    outcomes = {row.verdict for row in rows}
    return "not" if outcomes <= {"not"} else "reproduced" if outcomes == {"reproduced"} else "partly"


def _nearest(stresses: Stresses) -> tuple[str, str]:
    """Linear model whose wave models' ratio in table D.1, highest Hs, is nearest to print, and its values."""
    asked = list(RATIOS)[2:]
    off, words = {}, {}
    for wave in WAVE_MODELS:
        found = [] if wave == SECOND_ORDER else _by_seed(stresses, "D.1", HIGH, wave)
        if found:
            ours = [100.0 * float(np.mean([f[ratio] for f in found])) for ratio in asked]
            print_ = [100.0 * printed()["D.1"][ratio][f"{HIGH:g}"] for ratio in asked]
            off[wave] = max(abs(a - b) for a, b in zip(ours, print_, strict=True))
            words[wave] = " and ".join(
                f"{a:.0f} % (print {b:.0f} %)" for a, b in zip(ours, print_, strict=True)
            )
    best = min(off, key=lambda wave: off[wave])
    return best, words[best]


def _verdict(stresses: Stresses, rows: list[Row]) -> Verdict:
    """What came of the absolute stresses (first two ratios), and of the ratio of the wave models."""
    constant = [row for row in rows if WHEELER not in row.name]
    absolute = [row for row in constant if "ref/L_spec" in row.name or "ref/NL_spec" in row.name]
    waves = [row for row in constant if row not in absolute]
    best, words = _nearest(stresses)
    said = {"reproduced": "reproduced", "partly": "partly reproduced", "not": "not reproduced"}
    mild = ", and no factor of two is found" if max(abs(float(row.ours)) for row in absolute) < 50.0 else ""
    other = (
        "; the kinetic energy of figure 5.4 points to another one (wave-comparison)"
        if best == WHEELER
        else ""
    )
    why = (
        f"Weighted against specific Tp: {said[_outcome(absolute)]}, {_counted(absolute)}; less one it is "
        f"{_range(absolute, LOW)} at Hs 1.5 m and {_range(absolute, HIGH)} at 7.5 m{mild}. Second order "
        f"against linear: {said[_outcome(waves)]}, {_counted(waves)}; less one it is {_range(waves, LOW)} at "
        f"Hs 1.5 m and {_range(waves, HIGH)} at 7.5 m. Its size hangs on the linear model: of those tried "
        f"{best.removeprefix('linear, ')} comes nearest in table D.1 at 7.5 m, {words}{other}."
    )
    both = {_outcome(absolute), _outcome(waves)}
    return Verdict("partly" if len(both) > 1 else both.pop(), why)


def _range(rows: list[Row], hs: float) -> str:
    """Lowest to highest value of a height, and of the print."""
    some = [row for row in rows if f"Hs {hs:g} m" in row.name]
    if not some:
        return "not run"
    here, there = ([float(getattr(row, of)) for row in some] for of in ("ours", "printed"))
    return f"{min(here):.2g} to {max(here):.2g} % (print {min(there):.3g} to {max(there):.3g} %)"


def _figure(stresses: Stresses, periods: Periods) -> Figure:
    from owt_campaign.studies.plotting import BLUE, COLOURS, FAINT, canvas, legend

    scatter = printed()["scatter_330_deg"]
    heights = sorted({key[1] for key in periods})
    tables = sorted({key[0] for key in periods})
    found = _by_period(stresses, periods)
    figure, panels = canvas(1, len(heights), (4.5 * len(heights), 3.4))
    for panel, hs in zip(panels[0], heights, strict=True):
        for colour, name in zip(COLOURS, tables, strict=False):
            of = found[name, hs]
            look: dict[str, Any] = {"color": colour, "marker": "o", "ms": 3, "lw": 1.2}
            panel.plot(list(of), list(of.values()), label=FREQUENCY[name], **look)
        panel.axvline(scatter["weighted_tp_s"][f"{hs:g}"], color=BLUE, lw=0.8, ls=":")
        count = panel.twinx()
        count.bar(scatter["tp_s"], scatter["occurrences"][f"{hs:g}"], width=0.6, color=FAINT, alpha=0.35)
        if panel is panels[0, -1]:
            count.set_ylabel("occurrences (bars)")
        count.grid(False)
        panel.set_zorder(count.get_zorder() + 1)
        panel.patch.set_visible(False)
        panel.set(
            title=f"Hs {hs:g} m", xlabel="specific Tp [s]", xlim=(2.5, 23.0) if hs == LOW else (10.5, 16.5)
        )
    panels[0, 0].set_ylabel("total stress over that of the weighted Tp")
    legend(panels[0, 0])
    return figure
