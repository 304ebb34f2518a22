"""Thesis appendix C: regular wave of H 2.5 m, T 5 s on the OC4 jacket, moving surface against midpoints.

USFOS loads a whole element once its midpoint is wet, which is ``morison.surface`` "midpoint" here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from owt_campaign.studies.cases import MODEL
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import Row, StudyResult, Verdict, rows_table
from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_wave_node.core.loads import jacket_loads

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["HEIGHT", "PERIOD", "Forces", "compute", "run"]

HEIGHT, PERIOD = 2.5, 5.0
#: Hydrodynamic elements in m: the thesis' and what it is measured from.
ELEMENT, FINE = 1.0, 0.1
#: Steps per period: a zigzag needs more than the thesis' 50.
STEPS, FEWER = 500, 50

#: Largest difference of curves that match, over the largest force; roughness of the smoother over the other.
MATCH, SMOOTHER = 0.05, 0.2


@dataclass(frozen=True)
class Forces:
    """Total force along x in N over one period.

    Attributes
    ----------
    t : float array [time]
        In s.
    moving, midpoint : float arrays [time]
        Elements of 1 m, up to the surface or on and off by their midpoints.
    fine : float array [time]
        Elements of 0.1 m up to the surface.
    """

    t: Float[np.ndarray, " time"]
    moving: Float[np.ndarray, " time"]
    midpoint: Float[np.ndarray, " time"]
    fine: Float[np.ndarray, " time"]

    def off(self, name: str) -> float:
        """Largest difference of a force from the fine one, over its largest value."""
        return float(np.abs(getattr(self, name) - self.fine).max() / np.abs(self.fine).max())

    def roughness(self, name: str) -> float:
        """Total variation over one period, relative to that of the fine force, less one."""
        variation = [
            np.abs(np.diff(force, append=force[0])).sum() for force in (getattr(self, name), self.fine)
        ]
        return float(variation[0] / variation[1] - 1.0)


def compute(steps: int) -> Forces:
    """Forces in `steps` steps of one period."""
    mesh = build_mesh(load_structure(MODEL))

    def force(surface: str, element: float) -> Float[np.ndarray, " time"]:
        case = parse_case(
            {
                "regular": {"theory": "airy", "height_m": HEIGHT, "period_s": PERIOD},
                "wave": {"order": 1, "stretching": "constant"},
                "time": {"dt_s": PERIOD / steps, "n": steps},
                "morison": {"discretisation_m": element, "surface": surface},
            }
        )
        return np.ascontiguousarray(jacket_loads(case, mesh).force[:, 0])

    t = np.arange(steps) * PERIOD / steps
    return Forces(t, force("moving", ELEMENT), force("midpoint", ELEMENT), force("moving", FINE))


_HEAD = f"""\
Written by `./owt study usfos --full -o docs/study`.

Linear wave of H {HEIGHT:g} m and T {PERIOD:g} s along x on the jacket (`{MODEL}`) in 50 m of water, constant
extrapolation above still water, Cd 1, Cm 2, {STEPS} steps per period. The curves of USFOS are known as a
picture only, and the picture is lost; USFOS itself is no public code. What it does at the surface is known
(4.2.4): a whole element is loaded once its midpoint is wet. `morison.surface` "midpoint" does the same and
stands in for it. That the force itself is right is a matter of [verification](../verification.md): Morison's
equation written out over pieces of 0.05 m, row appendix-c.

Both curves here are of this code, so that a row is *partly* reproduced at best: if they differ by at most
{100 * MATCH:g} % of the largest force, and if the roughness of one is less than a fifth of the other's."""

_FIGURE = """\
## Figures C.1 and C.2: total force along x

![Total force over one period and around its maximum](usfos-force.png)

Differences are the largest over the period, over the largest force; roughness is the total variation over one
period beyond that of the fine curve."""


def run(*, full: bool, progress: Progress) -> StudyResult:
    """The study; reduced with a tenth of the steps."""
    found = compute(STEPS if full else FEWER)
    progress(1, 1)
    return _result(found, full=full)


def _result(found: Forces, *, full: bool) -> StudyResult:
    peaks = float(found.midpoint.max() / found.moving.max() - 1.0)
    apart = float(np.abs(found.midpoint - found.moving).max() / np.abs(found.fine).max())
    smooth, rough = found.roughness("moving"), found.roughness("midpoint")
    where = "appendix C, figures C.1, C.2"
    rows = [
        Row("largest force", where, None, float(found.fine.max()) * 1e-6, "MN"),
        Row(
            "largest difference of this code's two surfaces at any time, over the largest force",
            where,
            "the two models match perfectly",
            100.0 * apart,
            "%",
            verdict="not" if apart > MATCH else "partly",
        ),
        Row(
            "roughness, moving surface and midpoints",
            where,
            "ours is smoother",
            f"{100.0 * smooth:.2g} % and {100.0 * rough:.2g} %",
            verdict="partly" if abs(smooth) < SMOOTHER * rough else "not",
        ),
        Row(
            "difference from elements of 0.1 m, moving surface", where, None, 100.0 * found.off("moving"), "%"
        ),
        Row("difference from elements of 0.1 m, midpoints", where, None, 100.0 * found.off("midpoint"), "%"),
        Row("largest force, midpoints over moving surface, less one", where, None, 100.0 * peaks, "%"),
    ]
    said = {row.verdict for row in rows if row.verdict}
    verdict = Verdict(
        "not" if said == {"not"} else "partly",
        f"Roughness of the force with the moving surface {100.0 * smooth:.2g} %, with elements on and off by "
        f"their midpoints, as USFOS has them, {100.0 * rough:.2g} %; both are of this code and differ by up "
        f"to {100.0 * apart:.1f} % of the largest force, their peaks by {100.0 * abs(peaks):.1f} %. That the "
        "two programs match, as the thesis says, is not tested: USFOS itself was not run, and its printed "
        "curves are lost.",
    )
    title = "Total force on the jacket in a regular wave: thesis appendix C"
    sections = [_HEAD, rows_table(rows), _FIGURE]
    return StudyResult(
        "usfos", title, sections, rows, verdict, full=full, figures={"force": lambda: _figure(found)}
    )


def _figure(found: Forces) -> Figure:
    from owt_campaign.studies.plotting import BLUE, INK, ORANGE, canvas, legend

    figure, panels = canvas(1, 2, (9.0, 3.6))
    near = np.abs(found.t - found.t[found.fine.argmax()]) < 0.4
    for panel, title, at in zip(
        panels[0], ("one period", "around the maximum"), (found.t >= 0.0, near), strict=True
    ):
        t = found.t[at]
        panel.plot(t, 1e-6 * found.midpoint[at], color=ORANGE, lw=1.0, label="1 m, on and off at midpoints")
        panel.plot(t, 1e-6 * found.moving[at], color=BLUE, lw=1.8, label="1 m, moving surface")
        some = slice(None, None, max(1, t.size // 24))
        panel.plot(
            t[some], 1e-6 * found.fine[at][some], "o", color=INK, ms=2.5, label="0.1 m, moving surface"
        )
        panel.set(xlabel="time [s]", title=title)
    panels[0, 0].set_ylabel("total force along x [MN]")
    legend(panels[0, 0], loc="lower right")
    return figure
