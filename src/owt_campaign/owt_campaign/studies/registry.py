"""Which studies there are; nothing that computes is imported before one of them is run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from owt_campaign.studies.result import StudyResult

__all__ = ["STUDIES", "Progress", "Study", "run_study"]

#: Called with the number of runs that are done, and of all.
Progress = Callable[[float, float], None]


@dataclass(frozen=True)
class Study:
    """One study.

    Attributes
    ----------
    name : str
        As on the command line and in the names of its files.
    help : str
        One line.
    module : str
        Module of this package with ``run(*, full, progress) -> StudyResult``.
    """

    name: str
    help: str
    module: str


_ALL = (
    Study("eigen", "frequencies, damping and shapes: tables B.1 to B.3, figures B.1 to B.4", "eigen_page"),
    Study("interpolation", "error and time of three force distributions: figures 4.4, 4.5", "interpolation"),
    Study("usfos", "total force of a regular wave on the jacket: appendix C", "usfos"),
    Study("load-case-table", "weighted against specific Tp: tables D.1, D.2", "load_case_table"),
    Study(
        "wave-comparison",
        "second order against linear: figures 5.1 to 5.4, table 5.1",
        "wave_comparison_page",
    ),
    Study("sensitivity", "damping and frequency model: figures 5.5 to 5.7", "sensitivity_page"),
    Study("reduction", "reduced models: figures 6.1 to 6.3, tables 6.1 and 6.2", "reduction_page"),
    Study("modal-contribution", "energy per mode: figures 6.4 and 6.5", "modal_contribution_page"),
    Study("wind", "wave and wind loads on reduced models: figures 6.6 and 6.7", "wind"),
    Study("load-vectors", "vectors that steep waves of 2.5 to 17 m need: chapter 7.3.2", "load_vectors"),
    Study("beyond", "damage, error estimate, sampling, seeds, load factors: chapter 7.3", "beyond_page"),
)

#: Studies by name, in the order of the thesis.
STUDIES = {study.name: study for study in _ALL}


def run_study(name: str, *, full: bool = False, progress: Progress | None = None) -> StudyResult:
    """Run the study `name`.

    Parameters
    ----------
    name : str
        One of :data:`STUDIES`.
    full : bool
        As committed in docs/study; otherwise a reduced version that takes seconds.
    progress : callable, optional
        Called with the runs done and the runs in all.

    Raises
    ------
    InputError, ComputationError
        If a case of the study is refused, or its result cannot be trusted.
    """
    module = import_module(f"owt_campaign.studies.{STUDIES[name].module}")
    result: StudyResult = module.run(full=full, progress=progress or (lambda done, total: None))
    return result
