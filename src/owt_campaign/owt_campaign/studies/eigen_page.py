"""The study of frequencies and damping as a page: each table beside the print, and why they differ."""

from __future__ import annotations

from typing import Any

from owt_campaign.studies import eigen
from owt_campaign.studies.eigen import MODEL, EigenStudy
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

Held to 1 % up to mode 10 and to 3.1 % up to mode 20 (full and CB20). Load vectors of M20 and CB10M10:
second-order loads of Hs 8.25 m, Tp 11.5 s towards 210 degrees, seed 1; the thesis does not name its sea,
and the modes that such vectors make follow the loads. Modes of CB00 above 10 Hz are artefacts of the
basis."""

_KEPT = """\
### What the reductions keep

For each mode of the unreduced model the mode of the reduced one whose shape is most alike: error of its
frequency in percent, and likeness (modal assurance criterion in the mass) where that is below 0.99; a
dash where none among the lowest 20 is more alike than 0.5."""

_B2 = """\
## Table B.2: the jacket with its interface held

Held to 1.3 % of modes matched by symmetry: class A stays under a quarter turn, B is reversed, E is one
of a pair. Modes 4 and 5 have changed places."""

_B3 = """\
## Table B.3: reference, damping and frequency model

Held to 1.5 % of the decrement up to mode 10 and to 3 % up to mode 20. Damped frequencies, of Rayleigh
damping with alpha 0.027 1/s and beta 0.0020 s (frequency model: 0.021 and 0.0024, stiffness of the
jacket times 0.37). The thesis does not say how its damping model is damped; its print follows a dashpot
of 6.1e4 N s/m between tower top and ground, in x and y. Thirty percent given to the first two modes
alone (damping-modal, beside the same print) is the other reading: it leaves modes 3, 4 and 6 with up to
11 % less than the print."""


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

Figure B.4: the first five augmentation vectors of CB10M10 for the second-order loads of Hs 8.25 m,
Tp 11.5 s (towards 210 degrees, seed 1), with their pseudo-frequencies: the higher ones bend
members near the surface, which no mode above does."""

_TITLE = "Frequencies, damping and shapes: thesis tables B.1 to B.3, figures B.1 to B.4"

_VERDICT = Verdict(
    "reproduced",
    "The jacket's own frequencies come within 1.3 % and the turbine's within 1 % up to mode 10 (3.1 % up to "
    "mode 20), the decrements within 1.5 % (3 %). Tower and rotor-nacelle, which the thesis does not "
    "publish, were fitted to these tables.",
)


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
    sections = [
        _HEAD,
        _B1,
        _frequencies(study.table_b1, printed["table_B1"]),
        _KEPT,
        _kept(study),
        _B2,
        _fixed(study, printed["table_B2"]),
        _B3,
        _decrements(study, printed["table_B3"]),
        _SHAPES,
    ]
    rows = _rows(study, printed)
    return StudyResult("eigen", _TITLE, sections, rows, _VERDICT, figures=EIGEN_FIGURES, data=study.as_json())


def _rows(study: EigenStudy, printed: dict[str, Any]) -> list[Row]:
    """First and tenth mode of every column."""
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
        for i in (0, 9)
    ]


def _agreement(ours: float, printed: float) -> Outcome:
    off = abs(ours / printed - 1.0)
    return "reproduced" if off < 0.02 else "partly" if off < 0.05 else "not"


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
