"""Child processes of the bring-up: found through the ament index, logged to a file, never left behind.

Each child leads its own process group, so that a Ctrl-C reaches only the bring-up, which ends its
children in order. A child asks the kernel to be told when the bring-up dies
(:mod:`owt_ros.process`). No shell is involved.
"""

from __future__ import annotations

import fcntl
import os
import re
import secrets
import signal
import subprocess
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

from owt_model.errors import InputError
from owt_ros.process import PARENT_VARIABLE, TOKEN_VARIABLE

__all__ = ["Child", "find_executable", "remove_shared_memory", "shared_memory_of", "stop_all"]

#: Seconds that children have to end by themselves after SIGTERM.
PATIENCE_S = 4.0
_SEGMENT = re.compile(r"/dev/shm/fastdds_[0-9a-f]{16}$")


def find_executable(package: str, name: str) -> Path:
    """Return the executable `name` of `package`, as ``ros2 run`` finds it.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        path = Path(get_package_prefix(package)) / "lib" / package / name
    except PackageNotFoundError:
        path = Path()
    if not os.access(path, os.X_OK) or not path.is_file():
        raise InputError(
            "executable",
            f"{package} {name}",
            "is not installed",
            "Run ./owt setup, or build and source the workspace.",
        )
    return path


class Child:
    """One running executable.

    Parameters
    ----------
    name : str
        Used in messages.
    command : sequence of str
        Program and arguments.
    log : Path
        Where its standard output and error go.
    environment : mapping
        Environment variables.

    Raises
    ------
    InputError
        If it cannot be started.
    """

    def __init__(self, name: str, command: Sequence[str], log: Path, environment: Mapping[str, str]) -> None:
        self.name, self.log, self.token = name, log, secrets.token_hex(8)
        own = {PARENT_VARIABLE: str(os.getpid()), TOKEN_VARIABLE: self.token}
        try:
            with log.open("wb") as output:
                self._process = subprocess.Popen(
                    list(command),
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    env={**environment, **own, "PYTHONUNBUFFERED": "1"},
                    start_new_session=True,
                )
        except OSError as error:
            raise InputError(
                name, command[0], f"cannot be started ({error.strerror})", "Run ./owt setup."
            ) from None

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """Exit code, negative for a signal; None while it runs."""
        return self._process.poll()

    @property
    def last_line(self) -> str:
        """Last line that it wrote; empty if there is none."""
        lines = (
            self.log.read_text(encoding="utf-8", errors="replace").split("\n") if self.log.exists() else []
        )
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def describe_end(self) -> str:
        """Say in one line how it ended."""
        code = self.exit_code
        if code is None:
            return f"{self.name} is still running"
        if code < 0:
            how = f"{self.name} was killed by {signal.Signals(-code).name}"
        else:
            how = f"{self.name} ended with exit code {code}"
        return f"{how}: {self.last_line}" if self.last_line else how

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to its process group, if it still runs."""
        if self.exit_code is None:
            os.killpg(self.pid, number)

    def wait(self, seconds: float) -> bool:
        """Wait for its end; tell whether it came."""
        try:
            self._process.wait(max(seconds, 0.0))
        except subprocess.TimeoutExpired:
            return False
        return True


def shared_memory_of(pid: int | str) -> set[Path]:
    """Return the data segments of Fast DDS that a process uses; none once it has ended."""
    try:
        lines = Path(f"/proc/{pid}/maps").read_text(encoding="utf-8").splitlines()
    except OSError:
        return set()
    return {Path(match[0]) for line in lines if (match := _SEGMENT.search(line))}


def remove_shared_memory(files: Iterable[Path]) -> None:
    """Remove what killed processes left; what another process owns, or this one uses, stays.

    A process reads from the segments of all others in its domain, so some of `files` may belong to another
    graph: the owner of a segment holds a lock on the file beside it. Ports are left alone: graphs in other
    domains may share them.
    """
    for path in set(files) - shared_memory_of("self"):
        lock = path.with_name(f"{path.name}_el")
        if not _is_owned(lock):
            for file in (path, lock):
                with suppress(OSError):
                    file.unlink()


def _is_owned(lock: Path) -> bool:
    """Tell whether a process holds the lock of a segment."""
    try:
        fd = os.open(lock, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(fd)
    return False


def stop_all(children: Iterable[Child], *, patience_s: float = PATIENCE_S) -> None:
    """End all children: SIGTERM, and SIGKILL for those that take longer than `patience_s` seconds."""
    children = list(children)
    for child in children:
        child.signal(signal.SIGTERM)
    deadline = time.monotonic() + patience_s
    for child in children:
        if not child.wait(deadline - time.monotonic()):
            child.signal(signal.SIGKILL)
            child.wait(patience_s)
