"""A folder of finished runs, so that studies share them and a study that was stopped goes on.

Without a folder nothing is kept. Each run is a file of arrays named by the hash of all that it depends on.
"""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["FOLDER_VARIABLE", "Store"]

#: Environment variable that names the folder.
FOLDER_VARIABLE = "OWT_STUDY_RUNS"
#: Counts up when runs of the same key would give other numbers.
VERSION = 1

Arrays = Mapping[str, np.ndarray]


class Store:
    """Runs by what they depend on.

    Parameters
    ----------
    folder : Path, optional
        Where runs are kept; that of :data:`FOLDER_VARIABLE` where left out, nowhere without it.
    """

    def __init__(self, folder: Path | None = None) -> None:
        named = os.environ.get(FOLDER_VARIABLE)
        self.folder = folder if folder is not None else None if not named else Path(named)

    def run(self, key: Any, compute: Callable[[], Arrays]) -> dict[str, np.ndarray]:
        """Return the run of a key: the kept one where there is one, else what `compute` gives.

        Parameters
        ----------
        key : anything that JSON holds
            All that the run depends on.
        compute : callable
            Gives the arrays of the run, by name.
        """
        if self.folder is None:
            return dict(compute())
        text = json.dumps([VERSION, key], sort_keys=True)
        path = self.folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.npz"
        kept = _read(path)
        if kept is not None:
            return kept
        found = dict(compute())
        self.folder.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(f".{path.name}.{os.getpid()}")
        with partial.open("wb") as stream:
            np.savez_compressed(stream, **found)  # type: ignore[arg-type]
        partial.replace(path)
        return found


def _read(path: Path) -> dict[str, np.ndarray] | None:
    """Arrays of a file; None where there is none, or it is damaged."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            return {name: kept[name] for name in kept.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
