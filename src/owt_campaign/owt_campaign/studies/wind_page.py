"""The study of waves and wind on reduced models as a page: thesis figures 6.6 and 6.7."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, number, rows_table, table
from owt_campaign.studies.wind import LOADINGS, MODELS, SEAS, WindStudy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["wind_result"]

_HEAD = """\
Written by `./owt study wind --full -o docs/study`; model `oc4-thesis`.

Errors of mean and standard deviation of the potential energy of the whole turbine against the unreduced
model, with waves alone (W-O) and with one wind load added that is the same in all sea states (W-W). Sea
states of the load-case table from 330 and 270 degrees (Hs 0.75, 2.25, 4.25, 6.25, 8.25 m), three seeds of the
waves, 600 s: second order with Taylor expansion, cut-off 4 omega_p, each with load vectors of its own waves.
Loads are linear between samples of 0.1 s and integrated exactly.

The thesis takes one wind load at the rated wind speed, a force at the tower top; its series is not published.
Here it is the thrust of `wind.thrust` at 10.5 m/s (IEC category B, seed 1, towards 210 degrees, with the
peaks at three and six times the rotor speed), without aerodynamic damping. The figures are lost; the rows
hold what the text says of them.

A ranking is *reproduced* if the medians of every seed and two thirds of all runs have it, *partly* if the
medians of a seed have it. The modes represent more if their share grows by half a percent point in every
seed, *partly* if it grows at all. No linear waves are run."""

#: What errors are of, and the share of the runs that makes a ranking clear.
MEASURES, CLEAR = ("mean", "standard deviation"), 2.0 / 3.0

_ERRORS = """\
## Figure 6.6: errors of the potential energy

![Errors with and without wind](wind-errors.png)

Median over all runs (largest in brackets), in percent."""

_MODES = """\
## Figure 6.7: energy of the modes of CB10M10

![Share of each mode and vector](wind-modes.png)

Mean energy of each fixed-interface mode (1 to 10) and load vector (11 to 20) over that of the twenty [eq.
6.1], mean of the seeds; vectors by rising pseudo-frequency. Hs 0.75 m and Tp 6.34 s, 4.25 m and 9.25 s, 8.25
m and 11.50 s occur in the table from 270 degrees only, so these are from there."""


def wind_result(study: WindStudy, *, full: bool) -> StudyResult:
    """Page, rows, figures and verdict of the study."""
    rows = [*_ranking(study), *_shares(study)]
    sections = [
        _HEAD,
        "## What the thesis says of the figures\n\n" + rows_table(rows),
        _ERRORS,
        _table(study),
        _MODES,
    ]
    errors = [
        {"hs_m": cell.hs_m, "from_deg": cell.from_deg, "seed": seed, "model": model, "loading": loading,
         "mean": float(f"{value[0]:.4g}"), "std": float(f"{value[1]:.4g}")}
        for (cell, seed, model, loading), value in study.error.items()
    ]  # fmt: skip
    return StudyResult(
        "wind",
        "Waves and wind on reduced models: thesis figures 6.6 and 6.7",
        sections,
        rows,
        _verdict(study, rows),
        full=full,
        figures={"errors": lambda: _error_figure(study), "modes": lambda: _mode_figure(study)},
        data={"errors": errors},
    )


def _ratios(study: WindStudy, loading: str, column: int) -> Float[np.ndarray, " seed"]:
    """Median error of M20 over that of CB10M10, seed by seed."""
    return np.array(
        [
            np.median(study.errors("M20", loading, seed)[:, column])
            / np.median(study.errors("CB10M10", loading, seed)[:, column])
            for seed in study.seeds
        ]
    )


def _better(study: WindStudy, loading: str, column: int) -> float:
    """Share of the runs in which the model that the thesis names has the smaller error."""
    m20, cb = (study.errors(name, loading)[:, column] for name in ("M20", "CB10M10"))
    return float((m20 < cb).mean() if loading == "W-O" else (cb < m20).mean())


def _ranking(study: WindStudy) -> list[Row]:
    rows = []
    for loading, statement in zip(
        LOADINGS, ("M20 the more accurate", "CB10M10 the more accurate"), strict=True
    ):
        for column, what in enumerate(MEASURES):
            ratio, share = _ratios(study, loading, column), _better(study, loading, column)
            right = ratio < 1.0 if loading == "W-O" else ratio > 1.0
            verdict: Outcome = (
                "reproduced" if right.all() and share > CLEAR else "partly" if right.any() else "not"
            )
            rows.append(
                Row(f"median error of the {what}, M20 over CB10M10, {loading}", "6.4, figure 6.6", statement,
                    float(ratio.mean()), spread=(float(ratio.min()), float(ratio.max())), verdict=verdict)
            )  # fmt: skip
            rows.append(
                Row(f"runs in which that model has the smaller error of the {what}, {loading}",
                    "6.4, figure 6.6", None, 100.0 * share, "%")
            )  # fmt: skip
    return rows


def _shares(study: WindStudy) -> list[Row]:
    """Share of the fixed-interface modes with wind, against without: low to high sea state."""
    growth = {}
    rows = []
    for name in SEAS:
        still, windy = (study.modal_share(name, loading)[:, 0] for loading in LOADINGS)
        if not len(still):
            continue
        growth[name] = float(np.mean(windy - still))
        change = 100.0 * (windy - still)
        rows.append(
            Row(
                f"share of the fixed-interface modes, W-W less W-O, {name} sea state",
                "6.4, figure 6.7",
                "the modes represent a relatively higher part",
                float(change.mean()),
                "percent points",
                (float(change.min()), float(change.max())),
                "reproduced" if change.min() > 0.5 else "partly" if change.mean() > 0.0 else "not",
            )
        )
    if len(growth) == len(SEAS):
        largest = max(growth, key=lambda name: growth[name])
        rows.append(
            Row(
                "sea state in which wind changes the shares most",
                "6.4, figure 6.7",
                "low",
                largest,
                verdict="reproduced" if largest == "low" else "not",
            )
        )
    return rows


def _table(study: WindStudy) -> str:
    lines = []
    for loading in LOADINGS:
        for model in MODELS:
            error = 100.0 * study.errors(model, loading)
            cells = [f"{number(float(np.median(e)))} ({number(float(e.max()))})" for e in error.T]
            lines.append([loading, model, *cells])
    return table(["loads", "model", "mean", "standard deviation"], lines)


def _verdict(study: WindStudy, rows: list[Row]) -> Verdict:
    still = [float(1.0 / _ratios(study, "W-O", column).mean()) for column in (0, 1)]
    windy = [float(_ratios(study, "W-W", column).mean()) for column in (0, 1)]
    share = [100.0 * _better(study, "W-W", column) for column in (0, 1)]
    largest = 100.0 * max(study.errors(name, "W-W")[:, 0].max() for name in MODELS)
    first = (
        f"With waves alone M20 is {still[0]:.1f} times (mean) and {still[1]:.1f} times (standard "
        f"deviation) as accurate as CB10M10, with wind CB10M10 {windy[0]:.1f} and {windy[1]:.1f} times as "
        f"accurate as M20, in {share[0]:.0f} and {share[1]:.0f} % of the runs; with wind no mean is off by "
        f"more than {largest:.1g} %. Of the ranking of figure 6.6 {_ranks(rows)}. "
    )
    low = [study.modal_share("low", loading)[:, 0] for loading in LOADINGS]
    second = ""
    if len(low[0]):
        second = (
            f"The fixed-interface modes hold {100 * low[0].mean():.0f} % of the energy of the twenty in the "
            f"low sea state without wind and {100 * low[1].mean():.0f} % with it, where the thesis gives "
            f"almost all to the first vector without; {_gains(rows)}. "
        )
    third = "The thesis' wind load and the heights of its curves are lost."
    outcomes = {row.verdict for row in rows if row.verdict}
    return Verdict("not" if outcomes == {"not"} else "partly", first + second + third)


def _ranks(rows: list[Row]) -> str:
    """Which parts of the ranking hold."""
    held: dict[str, list[str]] = {}
    for row in rows:
        if row.name.startswith("median error of the"):
            held.setdefault(row.verdict, []).append(
                row.name.removeprefix("median error of the ").replace(", M20 over CB10M10,", "")
            )
    words = {"reproduced": "holds", "partly": "holds partly", "not": "does not hold"}
    return "; ".join(f"that of the {', '.join(held[key])} {words[key]}" for key in words if key in held)


def _gains(rows: list[Row]) -> str:
    """In which sea states wind raises the share of the modes, in words."""
    gained = {"reproduced": "wind raises it", "partly": "hardly raises it", "not": "does not raise it"}
    shares = [row for row in rows if row.name.startswith("share of the fixed")]
    return ", ".join(
        f"{gained[row.verdict or 'not']} in the {row.name.rsplit(', ', 1)[1]} ({float(row.ours):+.2g} points)"
        for row in shares
    )


def _error_figure(study: WindStudy) -> Figure:
    from owt_campaign.studies.plotting import BLUE, ORANGE, canvas, legend

    figure, panels = canvas(1, 2, (9.0, 3.6), share_y="row")
    runs = list(dict.fromkeys((cell, seed) for cell, seed, _, _ in study.error))
    runs.sort(key=lambda run: (run[0].hs_m, run[0].from_deg, run[1]))
    x = np.arange(1, len(runs) + 1)
    for panel, loading in zip(panels[0], LOADINGS, strict=True):
        for model, colour in zip(MODELS, (BLUE, ORANGE), strict=True):
            for column, (what, marker) in enumerate(zip(MEASURES, ("o", "x"), strict=True)):
                values = [100.0 * abs(study.error[cell, seed, model, loading][column]) for cell, seed in runs]
                panel.semilogy(x, values, marker, color=colour, ms=3.5, label=f"{model}, {what}")
        panel.set(title=f"{loading}", xlabel="run, by rising Hs")
    panels[0, 0].set_ylabel("error of the potential energy [%]")
    legend(panels[0, 0], ncols=2, loc="lower left")
    return figure


def _mode_figure(study: WindStudy) -> Figure:
    from owt_campaign.studies.plotting import BLUE, ORANGE, canvas, legend

    shown = [name for name in SEAS if len(study.modal_share(name, "W-O"))]
    figure, panels = canvas(len(LOADINGS), len(shown), (3.0 * len(shown), 4.4), share_x=True, share_y=True)
    for row, loading in zip(panels, LOADINGS, strict=True):
        for panel, name in zip(row, shown, strict=True):
            shares = [
                share
                for (cell, _, w), share in study.share.items()
                if w == loading and (cell.hs_m, cell.from_deg) == SEAS[name]
            ]
            mean = np.mean(shares, axis=0)
            x = np.arange(1, len(mean) + 1)
            panel.bar(x[:10], mean[:10], color=BLUE, label="fixed-interface modes")
            panel.bar(x[10:], mean[10:], color=ORANGE, label="load vectors")
            panel.set_title(f"{name} sea state, {loading}")
    for panel in panels[-1]:
        panel.set_xlabel("mode or vector")
    for panel in panels[:, 0]:
        panel.set_ylabel("share of the energy")
    legend(panels[0, -1])
    return figure
