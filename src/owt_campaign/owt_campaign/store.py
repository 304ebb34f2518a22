"""Finished results of a campaign in a folder: one file per case, named by its key, its checksum beside it.

A file appears whole or not at all, and its checksum after it. What has no checksum, or another one, is not
there: its case is computed again.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from owt_model.errors import InputError

__all__ = ["ResultStore"]


class ResultStore:
    """Results by the key of their case.

    Parameters
    ----------
    folder : Path
        Made where it is missing.

    Attributes
    ----------
    distrusted : list of str
        Keys of the results that were found but do not fit their checksum.

    Raises
    ------
    InputError
        If the folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.distrusted = folder, list[str]()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for left in folder.glob(".*.partial"):  # of a campaign that was killed
                left.unlink(missing_ok=True)
        except OSError as error:
            raise InputError(
                "output", str(folder), f"cannot be written to ({error.strerror})", "Choose another folder."
            ) from None

    def path(self, key: str) -> Path:
        """Where the result of a case lies."""
        return self.folder / f"{key}.npz"

    def get(self, key: str) -> bytes | None:
        """The bytes of a finished result; None if there is none that can be trusted."""
        path = self.path(key)
        try:
            data = path.read_bytes()
        except OSError:
            return None
        try:
            told = self._checksum_path(key).read_text(encoding="ascii")
        except (OSError, UnicodeDecodeError):
            told = ""
        if told == _checksum(path, data):  # the name too: files may have changed places
            return data
        self.distrusted.append(key)
        return None

    def put(self, key: str, data: bytes) -> None:
        """Keep a result.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        path, checksum = self.path(key), self._checksum_path(key)
        try:
            checksum.unlink(missing_ok=True)  # that of an older file would make the new one look corrupted
            _write(path, data)
            _write(checksum, _checksum(path, data).encode())
        except OSError as error:
            raise InputError(
                "output", str(path), f"cannot be written ({error.strerror})", "Check the free space."
            ) from None

    def _checksum_path(self, key: str) -> Path:
        return self.folder / f"{key}.sha256"


def _checksum(path: Path, data: bytes) -> str:
    """A line as ``sha256sum`` writes it."""
    return f"{hashlib.sha256(data).hexdigest()}  {path.name}\n"


def _write(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, onto the disk."""
    partial = path.with_name(f".{path.name}.partial")
    with partial.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())
    partial.replace(path)
