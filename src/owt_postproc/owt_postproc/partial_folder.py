"""A folder that appears under its name only when it is complete."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
from pathlib import Path

from owt_model.errors import InputError, StreamError

__all__ = ["PartialFolder", "partial_path", "sync"]

#: Nothing is begun with less than this much free space.
SMALLEST_FREE = 16 << 20


def partial_path(path: Path) -> Path:
    """Where the folder `path` lies until it is complete."""
    return path.parent / f".{path.name}.partial"


def sync(path: Path) -> None:
    """Flush a file or a folder to the disk."""
    fd = os.open(path, os.O_RDONLY)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)


class PartialFolder:
    """The folder ``.NAME.partial`` beside NAME, locked against other writers until it is released.

    Parameters
    ----------
    path : path
        The final name.
    overwrite : bool
        Replace a bag of that name once the new one is complete, and drop an unfinished one at once. Without
        it an existing name is refused, and an unfinished folder is moved to ``.NAME.partial.1`` and so on.
    expected_bytes : int
        Size that the caller expects; what would not fit is refused at once.

    Raises
    ------
    InputError
        If nothing can be written there.
    """

    def __init__(self, path: str | Path, *, overwrite: bool = False, expected_bytes: int = 0) -> None:
        self.path = Path(path).absolute()
        self.folder = partial_path(self.path)
        self._overwrite = overwrite
        self._fd = -1
        self._refuse_existing()
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._clear_unfinished()
            self._check_space(expected_bytes)
            self.folder.mkdir()
            self._fd = os.open(self.folder, os.O_RDONLY | os.O_CLOEXEC)
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self.release()
            raise InputError(
                "bag", str(self.path), f"cannot be written ({error.strerror})", "Choose a writable folder."
            ) from None

    def _refuse_existing(self) -> None:
        if not self.path.name:
            raise InputError("bag", str(self.path), "is not the name of a folder", "Give a new folder.")
        if not os.path.lexists(self.path):
            return
        if not self._overwrite:
            raise InputError("bag", str(self.path), "exists already", "Choose another name or remove it.")
        if not self.path.is_dir() or (any(self.path.iterdir()) and not any(self.path.glob("*.mcap"))):
            raise InputError(
                "bag", str(self.path), "exists and is not a bag", "It is not replaced; choose another name."
            )

    def _clear_unfinished(self) -> None:
        if not self.folder.is_dir():
            return
        fd = os.open(self.folder, os.O_RDONLY | os.O_CLOEXEC)
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                "bag", str(self.path), "is being recorded by another process", "Choose another name."
            ) from None
        finally:
            os.close(fd)
        if self._overwrite:
            shutil.rmtree(self.folder)
            return
        number = 1
        while (aside := self.folder.with_name(f"{self.folder.name}.{number}")).exists():
            number += 1
        self.folder.rename(aside)

    def _check_space(self, expected_bytes: int) -> None:
        free, needed = shutil.disk_usage(self.path.parent).free, max(expected_bytes, SMALLEST_FREE)
        if free < needed:
            raise InputError(
                "bag",
                str(self.path),
                f"needs about {needed >> 20} MiB, and {free >> 20} MiB are free",
                "Free some space or record elsewhere.",
            )

    def publish(self) -> None:
        """Give the folder its name, in the place of an old one where that was asked for.

        Raises
        ------
        StreamError
            If that cannot be done; the partial folder stays.
        """
        old = self.folder.with_name(f".{self.path.name}.old")
        try:
            sync(self.folder)
            if os.path.lexists(self.path):
                if not self._overwrite:
                    raise FileExistsError(errno.EEXIST, "that name appeared meanwhile")
                shutil.rmtree(old, ignore_errors=True)
                self.path.rename(old)
            self.folder.rename(self.path)
            sync(self.path.parent)
        except OSError as error:
            if old.exists() and not self.path.exists():
                old.rename(self.path)
            raise self.failure(f"cannot be completed ({error.strerror})") from None
        shutil.rmtree(old, ignore_errors=True)
        self.release()

    def failure(self, reason: str) -> StreamError:
        """The error of a recording that broke off."""
        return StreamError(f"bag {self.path}: {reason}; what was recorded is kept in {self.folder}.")

    def release(self) -> None:
        """Unlock; the folder stays as it is."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
