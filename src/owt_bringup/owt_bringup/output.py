"""What the commands write: files that appear whole or not at all, and a progress bar on a terminal."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from owt_model.errors import InputError

__all__ = ["NpzFile", "ProgressBar", "atomic_path", "npz_file", "prepare_folder", "write_json", "write_npz"]


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; it becomes `path` only if the block succeeds.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    folder = path.absolute().parent
    if path.exists() and not path.is_file():
        raise InputError("output", str(path), "exists and is no regular file", "Choose another name.")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".partial", dir=folder)
        os.close(handle)
    except OSError as error:
        raise InputError(
            "output",
            str(path),
            f"cannot be written ({error.strerror})",
            "Choose an existing, writable folder.",
        ) from None
    partial = Path(name)
    try:
        yield partial
        partial.chmod(0o644)
        partial.replace(path)
    except OSError as error:
        raise InputError(
            "output",
            str(path),
            f"cannot be written ({error.strerror})",
            "Check the folder and the free space.",
        ) from None
    finally:
        partial.unlink(missing_ok=True)


def prepare_folder(path: Path) -> Path:
    """Create the folder `path` if need be.

    Raises
    ------
    InputError
        If it cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            "output", str(path), f"cannot be made a folder ({error.strerror})", "Choose another place."
        ) from None
    if not os.access(path, os.W_OK):
        raise InputError("output", str(path), "is not writable", "Choose another folder.")
    return path


def write_npz(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Write arrays as one npz file, whole or not at all.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    with atomic_path(path) as partial, partial.open("wb") as stream:
        np.savez(stream, allow_pickle=False, **arrays)


class NpzFile:
    """An npz file under way: whole arrays, and one array at a time that is written row by row."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive

    def add(self, name: str, array: np.ndarray) -> None:
        """Add a whole array."""
        with self.rows(name, array.shape, array.dtype) as write:
            write(array)

    @contextmanager
    def rows(
        self, name: str, shape: tuple[int, ...], dtype: np.dtype[Any]
    ) -> Iterator[Callable[[np.ndarray], int]]:
        """Yield what writes consecutive rows of an array of given shape; `shape` counts them all."""
        header = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        with self._archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
            np.lib.format.write_array_header_1_0(stream, header)
            yield lambda rows: stream.write(np.ascontiguousarray(rows, dtype).data)


@contextmanager
def npz_file(path: Path) -> Iterator[NpzFile]:
    """Open an npz file that appears at `path` if the block succeeds.

    Raises
    ------
    InputError
        If nothing can be written there.
    """
    with atomic_path(path) as partial, zipfile.ZipFile(partial, "w") as archive:
        yield NpzFile(archive)


def write_json(path: Path, data: Any) -> None:
    """Write `data` as JSON (no NaN), whole or not at all."""
    with atomic_path(path) as partial:
        partial.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")


class ProgressBar:
    """One line on a terminal that shows what is done and the speed; silent elsewhere.

    Counts simulated time in s, or something else that `unit` names.
    """

    def __init__(self, label: str, unit: str = "s") -> None:
        self._label, self._unit, self._start, self._shown = label, unit, time.perf_counter(), 0.0
        self._active = sys.stderr.isatty()

    @property
    def callback(self) -> Callable[[float, float], None]:
        """What a long computation calls with the time reached and the duration, in s."""
        return self._update

    def _update(self, reached: float, duration: float) -> None:
        now = time.perf_counter()
        if not self._active or (now - self._shown < 0.1 and reached < duration):
            return
        self._shown = now
        share = reached / duration if duration else 1.0
        speed = reached / max(now - self._start, 1e-9)
        filled = "#" * int(30 * share)
        pace = f"{speed:.0f} x" if self._unit == "s" else f"{speed:.3g} per s"
        state = f"{100 * share:3.0f} %  {reached:.0f} of {duration:.0f} {self._unit}, {pace}"
        print(
            f"\r{self._label} [{filled:<30}] {state}",
            end="",
            file=sys.stderr,
            flush=True,
        )

    def close(self) -> None:
        """Leave the terminal on a clean line."""
        if self._active and self._shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
