"""What a result depends on, as hashes: the case, the files that it names, the structure and the code."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_model.structure import case_structure

__all__ = ["FORMAT", "case_key", "code_hash", "structure_hash"]

#: Counts up when a result file changes its meaning.
FORMAT = 1
#: Parts of a case that change no number of its outcome.
WITHOUT_EFFECT: Any = {
    "stream": True,
    "points_m": True,
    "fatigue": {"design_life_years", "design_fatigue_factor"},
}
#: What computes an outcome: sources of these packages and folders, and the versions of these libraries.
SOURCES = (
    ("owt_model", ("*.py", "structures/*")),
    ("owt_wave_node", ("*.py", "core/*.py", "kernels/*.py", "data/*")),
    ("owt_structure_node", ("*.py", "core/*.py", "kernels/*.py", "data/*")),
    ("owt_postproc", ("core/*.py", "kernels/*.py", "data/*.yaml")),
    ("owt_campaign", ("engine.py", "clusters.py", "shared_model.py", "kept_series.py", "pipeline.py")),
)
LIBRARIES = ("numpy", "scipy", "numba")


@cache
def code_hash() -> str:
    """SHA-256 of the code that computes an outcome and of the versions of its libraries.

    Nodes, bags and reports do not count: a change there recomputes nothing.
    """
    digest = hashlib.sha256()
    for path in sorted(_sources(), key=lambda path: (path.parent.name, path.name)):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    for name in LIBRARIES:
        digest.update(f"{name} {version(name)}\0".encode())
    return digest.hexdigest()


def _sources() -> Iterator[Path]:
    for package, patterns in SOURCES:
        root = Path(import_module(package).__file__ or "").parent
        for pattern in patterns:
            yield from (path for path in root.glob(pattern) if path.name != "node.py" and path.is_file())


def structure_hash(case: CaseConfig) -> str:
    """Hash of the content of the structure that a case names.

    Raises
    ------
    InputError
        If it cannot be read or is refused.
    """
    return str(case_structure(case.structure).content_hash)


def case_key(case: CaseConfig, structure: str, *, basis: str = "", keep: Iterable[str] = ()) -> str:
    """SHA-256 of all that the outcome of a case depends on.

    Parameters
    ----------
    case : CaseConfig
        The case; files that it names count by their content.
    structure : str
        From :func:`structure_hash`.
    basis : str
        What tells the load vectors shared by several cases; empty where the case has its own.
    keep : iterable of str
        Series that are kept.

    Raises
    ------
    InputError
        If a file cannot be read.
    """
    content = {
        "format": FORMAT,
        "code": code_hash(),
        "case": case.model_dump(mode="json", exclude=WITHOUT_EFFECT),
        "files": {name: _file_hash(name, path) for name, path in _files(case)},
        "structure": structure,
        "basis": basis,
        "keep": sorted(keep),
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _files(case: CaseConfig) -> Iterator[tuple[str, str]]:
    """Field and path of the files that a case names, but for its structure."""
    if case.spectrum_file is not None:
        yield "spectrum_file.path", case.spectrum_file.path
    if case.measured is not None:
        yield "measured.path", case.measured.path
    if case.wind is not None and case.wind.series is not None:
        yield "wind.series.path", case.wind.series.path
    if case.fatigue.sn_file is not None:
        yield "fatigue.sn_file", case.fatigue.sn_file


def _file_hash(field: str, path: str) -> str:
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(field, path, f"cannot be read ({error.strerror})", "Give a readable file.") from None
