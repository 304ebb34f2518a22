"""The study of frequencies and damping as a page: each table beside the print, and why they differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from owt_campaign.studies import eigen
from owt_campaign.studies.eigen import MODEL, PRINTED_CLASSES, EigenStudy
from owt_campaign.studies.eigen_figures import EIGEN_FIGURES
from owt_campaign.studies.registry import Progress
from owt_campaign.studies.result import Outcome, Row, StudyResult, Verdict, table

__all__ = ["eigen_page", "eigen_result", "run"]

_HEAD = f"""\
Written by `./owt study eigen -o docs/study`; model `{MODEL}`. Frequencies in Hz, logarithmic decrements
in percent; differences in percent of the print, mode by mode in the print's order.

Why they differ. Of the thesis' turbine neither wall thickness of the tower nor mass and inertia of the
rotor-nacelle are published; those of `{MODEL}` were fitted to table B.1 and to the frequency model of
table B.3, so that modes 1 to 10 show that the model is the fitted one, and predict nothing. The jacket
is known through its frequencies only: growth, flood water and added mass are isotropic masses at the 64
joints, as that comes nearest to table B.2; distributed along the members (model `oc4`) the frequencies
lie up to 5.5 % from it. The pair 18, 19 and heave (16) stay 2.9 % and 1.8 % low with any such model."""

_B1 = """\
## Table B.1: the whole turbine

Load vectors of M20 and CB10M10: second-order loads alone (Taylor expansion, cut-off 4 omega_p, 600 s) of Hs
8.25 m, Tp 11.5 s towards 210 degrees, seed 1; the thesis does not name the sea of this table, and the modes
that such vectors make follow the loads. Modes of CB00 above 10 Hz are artefacts of the basis.

{differences}"""

#: Differences from the print up to which a value is reproduced, and partly so.
_NEAR, _FAR = 0.02, 0.05
_RULE = f"""\
Every printed value is a row of the JSON file: *reproduced* within {100 * _NEAR:g} % of the print, *partly*
within {100 * _FAR:g} %, else *not*."""

_KEPT = """\
### What the reductions keep

For each mode of the unreduced model the mode of the reduced one whose shape is most alike: error of its
frequency in percent, and likeness (modal assurance criterion in the mass) where that is below 0.99; a
dash where none among the lowest 20 is more alike than 0.5."""

_B2 = """\
## Table B.2: the jacket with its interface held

Mode by mode in the print's order. Class A stays under a quarter turn, B is reversed, E is one of a pair.
{differences}"""

_B3 = """\
## Table B.3: reference, damping and frequency model

Damped frequencies, of Rayleigh damping with alpha 0.027 1/s and beta 0.0020 s (frequency model: 0.021 and
0.0024, stiffness of the jacket times 0.37). The thesis prints none of these four; they were fitted to this
table. Nor does it say how its damping model is damped; its print follows a dashpot of 6.1e4 N s/m, fitted
too, between tower top and ground, in x and y. Thirty percent given to the first two modes
alone (damping-modal, beside the same print) is the other reading.

{differences}"""


_SHAPES = """\
## Figures B.1 to B.4: shapes

The print's figures are lost; the order of the modes is that of the tables. Motions are enlarged, the
structure at rest is grey.

![First ten modes of the turbine](eigen-modes.png)

Figure B.1: the first ten modes of the whole turbine.

![Six constraint modes](eigen-constraint-modes.png)

Figure B.2: the six static constraint modes; translations x, y, z and rotations of the interface.

![First ten fixed-interface modes](eigen-fixed-interface-modes.png)

Figure B.3: the first ten modes with the interface held.

![First five load vectors](eigen-load-vectors.png)

Figure B.4: the first five augmentation vectors of CB10M10, with their pseudo-frequencies. The thesis names
the high load case of section 6.3: Hs 8.25 m, Tp 11.5 s, which table 4.5 has from 270 degrees only, so that
the waves of this figure travel towards 270 degrees (table B.1: 210); else its loads are those of table B.1.
They bend members near the surface, which no mode above does."""

#: Columns of table B.1 that no load vectors go into, and that keep the modes of the turbine.
_WHOLE = ("full", "CB20")
_TITLE = "Frequencies, damping and shapes: thesis tables B.1 to B.3, figures B.1 to B.4"


def run(*, full: bool, progress: Progress) -> StudyResult:
    """The study; it has one version."""
    return eigen_result(eigen.eigen_study(), eigen.thesis_tables())


def eigen_page(study: EigenStudy, printed: dict[str, Any]) -> str:
    """Write the page in Markdown.

    Parameters
    ----------
    study : EigenStudy
        From :func:`~owt_campaign.studies.eigen.eigen_study`.
    printed : dict
        From :func:`~owt_campaign.studies.eigen.thesis_tables`.
    """
    return eigen_result(study, printed).page


def eigen_result(study: EigenStudy, printed: dict[str, Any]) -> StudyResult:
    """Tables, rows and verdict of the study; arguments as of :func:`eigen_page`."""
    rows = _rows(study, printed)
    modal = np.array(study.table_b3["damping-modal"]["logdec_percent"][:10])
    less = 100.0 * (modal / printed["table_B3"]["damping"]["logdec_percent"][:10] - 1.0)
    by_modes = (
        f"Damping-modal up to mode 10: {less.min():.0f} to {less.max():+.1f} % from the same decrements."
    )
    sections = [
        f"{_HEAD}\n\n{_RULE}",
        _B1.format(differences=_held(rows, "table B.1")),
        _frequencies(study.table_b1, printed["table_B1"]),
        _KEPT,
        _kept(study),
        _B2.format(differences=_classes(study) + _held(rows, "table B.2")),
        _fixed(study, printed["table_B2"]),
        _B3.format(differences=f"{_held(rows, 'table B.3')} {by_modes}"),
        _decrements(study, printed["table_B3"]),
        _SHAPES,
    ]
    return StudyResult(
        "eigen", _TITLE, sections, rows, _verdict(rows), figures=EIGEN_FIGURES, data=study.as_json()
    )


def _rows(study: EigenStudy, printed: dict[str, Any]) -> list[Row]:
    """Every mode of every column."""
    columns = [
        (f"table B.1, {name}", "Hz", printed["table_B1"][name], study.table_b1[name])
        for name in printed["table_B1"]
    ]
    columns.append(("table B.2", "Hz", printed["table_B2"], study.table_b2))
    for name, print_ in printed["table_B3"].items():
        for key, unit in (("frequency_hz", "Hz"), ("logdec_percent", "%")):
            columns.append((f"table B.3, {name}", unit, print_[key], study.table_b3[name][key]))
    return [
        Row(f"mode {i + 1}", where, print_[i], ours[i], unit, verdict=_agreement(ours[i], print_[i]))
        for where, unit, print_, ours in columns
        for i in range(len(print_))
    ]


def _agreement(ours: float, printed: float) -> Outcome:
    off = abs(ours / printed - 1.0)
    return "reproduced" if off < _NEAR else "partly" if off < _FAR else "not"


def _columns(rows: list[Row], table_: str) -> dict[str, list[float]]:
    """Differences from the print in percent of the columns of a table, by name and unit, in its order."""
    found: dict[str, list[float]] = {}
    for row in rows:
        if row.where.startswith(table_):
            what = {"%": ", decrement", "Hz": ""}[row.unit]
            off = 100.0 * (float(row.ours) / float(row.printed or np.nan) - 1.0)
            found.setdefault(row.where.removeprefix(table_).lstrip(", ") + what, []).append(off)
    return found


def _held(rows: list[Row], table_: str) -> str:
    """Largest differences of the columns of a table up to mode 10, and of all."""
    words = []
    for name, off in _columns(rows, table_).items():
        first, every = (max(np.abs(some)) for some in (off[:10], off))
        beyond = "" if len(off) <= 10 else f" (up to mode 20: {every:.1f} %)"
        words.append(f"{name + ' ' if name else ''}{first:.1f} %{beyond}")
    return f"Largest differences up to mode 10: {', '.join(words)}."


def _classes(study: EigenStudy) -> str:
    """Whether the modes of table B.2 come in the order that the print's symmetry asks for."""
    moved = [
        str(i + 1)
        for i, (ours, print_) in enumerate(zip(study.class_b2, PRINTED_CLASSES, strict=True))
        if ours != print_
    ]
    return f"Modes {' and '.join(moved)} have changed places. " if moved else ""


def _verdict(rows: list[Row]) -> Verdict:
    """What came of all printed values, and where they are off."""
    seen = {what: sum(row.verdict == what for row in rows) for what in ("reproduced", "partly", "not")}
    b1, b2, b3 = (_columns(rows, f"table B.{number}") for number in (1, 2, 3))

    def span(names: Sequence[str], columns: dict[str, list[float]], last: int = 20) -> str:
        return f"{max(max(np.abs(columns[name][:last])) for name in names):.1f} %"

    damped = [name for name in b3 if name.endswith("decrement")]
    others = [name for name in b1 if name not in _WHOLE]
    why = (
        f"Of {len(rows)} printed values {seen['reproduced']} come within {100 * _NEAR:g} %, {seen['partly']} "
        f"within {100 * _FAR:g} % and {seen['not']} do not. The jacket's own frequencies come within "
        f"{span([''], b2)}, the turbine's (full and CB20) within {span(_WHOLE, b1, 10)} up to mode 10 and "
        f"{span(_WHOLE, b1)} up to mode 20, the decrements within {span(damped, b3, 10)} and "
        f"{span(damped, b3)}. Of the other reductions, whose higher modes follow loads that the thesis does "
        "not name or are artefacts, the largest differences are "
        + ", ".join(f"{min(b1[name]):+.1f} to {max(b1[name]):+.1f} % ({name})" for name in others)
        + ". Tower, rotor-nacelle, masses at the joints and damping, which the thesis does not publish, were "
        "fitted to these tables."
    )
    return Verdict("reproduced" if seen["reproduced"] == len(rows) else "partly", why)


def _percent(found: float, printed: float) -> str:
    return f"{100.0 * (found / printed - 1.0):+.2f}"


def _frequencies(found: dict[str, list[float]], printed: dict[str, list[float]]) -> str:
    head = ["mode", *(f"{name}: {what}" for name in printed for what in ("print", "here", "%"))]
    rows = []
    for i in range(len(printed["full"])):
        row = [str(i + 1)]
        for name, column in printed.items():
            row += [f"{column[i]:.3f}", f"{found[name][i]:.3f}", _percent(found[name][i], column[i])]
        rows.append(row)
    return table(head, rows)


def _kept(study: EigenStudy) -> str:
    rows = []
    for i, frequency in enumerate(study.table_b1["full"]):
        row = [str(i + 1), f"{frequency:.3f}"]
        for name, pairs in study.match.items():
            place = [j for j, (mode, likeness) in enumerate(pairs) if mode == i and likeness > 0.5]
            if not place:
                row.append("-")
                continue
            likeness = pairs[place[0]][1]
            error = f"{100.0 * (study.table_b1[name][place[0]] / frequency - 1.0):.2f}"
            row.append(error if likeness >= 0.99 else f"{error} ({likeness:.2f})")
        rows.append(row)
    return table(["mode", "full [Hz]", *study.match], rows)


def _fixed(study: EigenStudy, printed: list[float]) -> str:
    rows = [
        [str(i + 1), f"{p:.3f}", f"{f:.3f}", kind, _percent(f, p)]
        for i, (p, f, kind) in enumerate(zip(printed, study.table_b2, study.class_b2, strict=True))
    ]
    return table(["mode", "print", "here", "class here", "%"], rows)


def _decrements(study: EigenStudy, printed: dict[str, dict[str, list[float]]]) -> str:
    names = [*printed, "damping-modal"]
    head = ["mode"]
    for name in names:
        head += [f"{name}: f here", "f %", "decrement: print", "here", "%"]
    rows = []
    for i in range(len(study.table_b1["full"])):
        row = [str(i + 1)]
        for name in names:
            found, print_ = study.table_b3[name], printed.get(name, printed["damping"])
            f, d = found["frequency_hz"][i], found["logdec_percent"][i]
            f_print, d_print = print_["frequency_hz"][i], print_["logdec_percent"][i]
            row += [f"{f:.3f}", _percent(f, f_print), f"{d_print:.3f}", f"{d:.3f}", _percent(d, d_print)]
        rows.append(row)
    return table(head, rows)
