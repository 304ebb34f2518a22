"""Where calls are made: in this process, or by the workers of a Dask cluster."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import islice
from types import TracebackType
from typing import Any, Generic, Protocol, Self, TypeVar
from urllib.parse import urlsplit

from owt_model.errors import ComputationError, InputError

__all__ = ["MEMORY_LIMIT_MIB", "DaskPool", "Done", "InProcess", "Pool", "WorkerLostError"]

Job = TypeVar("Job")
Result = TypeVar("Result")
#: Job, function and arguments of one call; an argument may be what ``shared`` returned.
Call = tuple[Job, Callable[..., Result], tuple[object, ...]]

#: Memory of a worker of the local cluster, above which it is started again.
MEMORY_LIMIT_MIB = 2048
#: Workers that may die under a case before it counts as failed.
ALLOWED_DEATHS = 2
#: Calls submitted per thread of the cluster: one that runs and those that wait beside it.
IN_FLIGHT = 2
CONNECT_TIMEOUT = 10.0
#: Seconds between looks whether there are workers at all, and how many without any end the work.
LOOK_EVERY, PATIENCE = 5.0, 60.0
#: Transports of Dask.
SCHEMES = ("tcp", "tls", "ws", "wss", "ucx")
#: What workers of this machine import when they start.
CASE_MODULE = "owt_campaign.worker"
#: Variables that hold the threads of the libraries in a worker, and of this project.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "OWT_THREADS")


class WorkerLostError(ComputationError):
    """The workers that ran a call died."""


@dataclass(frozen=True)
class Done(Generic[Job, Result]):
    """A call that ended."""

    job: Job
    result: Result | WorkerLostError


class Pool(Protocol):
    """Makes calls, several at a time perhaps."""

    @property
    def description(self) -> str:
        """One line that says where."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *details: Any) -> None: ...

    def shared(self, function: Callable[..., Any], *arguments: object) -> Any:
        """Make a call whose result others take as an argument."""

    def run(self, calls: Iterable[Call[Job, Result]]) -> Iterator[Done[Job, Result]]:
        """Make calls; yield each as it ends."""


class InProcess:
    """Makes one call after the other in this process."""

    description = "in this process, one case at a time"

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, *details: object) -> None:
        """Nothing to close."""

    def shared(self, function: Callable[..., Any], *arguments: object) -> Any:
        """Make the call."""
        return function(*arguments)

    def run(self, calls: Iterable[Call[Job, Result]]) -> Iterator[Done[Job, Result]]:
        """Make calls; yield each as it ends."""
        for job, function, arguments in calls:
            yield Done(job, function(*arguments))


class DaskPool:
    """Makes calls on a Dask cluster: one on this machine, or that of a scheduler.

    Parameters
    ----------
    workers : int
        Processes of the cluster on this machine.
    scheduler : str, optional
        Address of another scheduler, which is used instead.
    """

    def __init__(self, workers: int, scheduler: str | None = None) -> None:
        self._workers, self._address = workers, scheduler
        self._stack = ExitStack()
        self._client: Any = None
        self.description = ""

    def __enter__(self) -> Self:
        """Start the cluster, or connect to the scheduler.

        Raises
        ------
        InputError
            If there is none at the address, or it has no worker.
        """
        import dask
        import distributed  # noqa: F401  its defaults first, lest they are taken for ours and removed with them

        settings = {
            # The same bits and no quarrel over processors: one thread of every library in each worker.
            "distributed.nanny.pre-spawn-environ": dict.fromkeys(THREADS, "1"),
            "distributed.scheduler.allowed-failures": ALLOWED_DEATHS,
            "distributed.comm.timeouts.connect": f"{CONNECT_TIMEOUT:g}s",
            "distributed.admin.log-format": "%(name)s: %(message)s",
            # Workers import what a case needs while they start, side by side, not when the first one comes.
            "distributed.worker.preload": [CASE_MODULE],
            # A case takes a second: nothing is gained by looking at the loops and the stacks a hundred times.
            "distributed.admin.tick.interval": "500ms",
            "distributed.worker.profile.enabled": False,
        }
        try:
            self._stack.enter_context(dask.config.set(settings))
            self._client = self._stack.enter_context(self._connect())
        except BaseException:
            self._stack.close()
            raise
        return self

    def _connect(self) -> Any:
        from distributed import Client, LocalCluster

        if self._address is not None:
            _check_address(self._address)
            try:
                client = Client(self._address, timeout=CONNECT_TIMEOUT, set_as_default=False)
            except (OSError, ValueError, TypeError) as error:
                reason = " ".join(str(error).split()) or type(error).__name__
                raise InputError(
                    "scheduler", self._address, f"is not reached ({reason})", "Give tcp://HOST:PORT of one."
                ) from None
            self.description = (
                f"{len(client.nthreads())} workers of {self._address}, dashboard {client.dashboard_link}"
            )
            return client
        folder = self._stack.enter_context(tempfile.TemporaryDirectory(prefix="owt-dask-"))
        cluster = self._stack.enter_context(
            LocalCluster(
                n_workers=self._workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                memory_limit=f"{MEMORY_LIMIT_MIB}MiB",
                local_directory=folder,
                silence_logs=50,
            )
        )
        count = f"{self._workers} worker{'s' if self._workers != 1 else ''}"
        self.description = (
            f"{count} of one thread and at most {MEMORY_LIMIT_MIB} MiB, dashboard {cluster.dashboard_link}"
        )
        return Client(cluster, set_as_default=False)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the cluster, or leave the scheduler to others."""
        with suppress(TimeoutError, OSError):
            self._stack.close()

    def shared(self, function: Callable[..., Any], *arguments: object) -> Any:
        """Make a call whose result others take as an argument; it is not waited for."""
        return self._client.submit(function, *arguments, pure=False)

    def run(self, calls: Iterable[Call[Job, Result]]) -> Iterator[Done[Job, Result]]:
        """Make calls; yield each as it ends. A few are submitted ahead, whatever their number.

        Raises
        ------
        ComputationError
            If the scheduler is lost, or all its workers are.
        """
        lost: list[Call[Job, Result]] = []
        for call, result in self._ended(iter(calls)):
            if isinstance(result, WorkerLostError):
                lost.append(call)
            else:
                yield Done(call[0], result)
        # Dask blames all calls that waited at a worker which died. Alone, only the guilty one kills it again.
        for one in lost:
            for call, result in self._ended(iter([one])):
                yield Done(call[0], result)

    def _ended(
        self, waiting: Iterator[Call[Job, Result]]
    ) -> Iterator[tuple[Call[Job, Result], Result | WorkerLostError]]:
        """Calls with their results, as they end."""
        jobs = dict[Any, Call[Job, Result]]()
        while True:
            limit = IN_FLIGHT * max(1, sum(self._client.nthreads().values()))
            for call in islice(waiting, limit - len(jobs)):
                _, function, arguments = call
                jobs[self._client.submit(function, *arguments, pure=False)] = call
            if not jobs:
                return
            for future in self._first(list(jobs)):
                yield jobs.pop(future), _result(future)

    def _first(self, futures: list[Any]) -> list[Any]:
        """Futures that have ended, one at least, in their order; an error when nobody works on them."""
        from distributed import CancelledError, wait

        since = time.monotonic()
        while True:
            try:
                with self._client.as_current():
                    ended = wait(futures, timeout=LOOK_EVERY, return_when="FIRST_COMPLETED").done
                return [future for future in futures if future in ended]
            except CancelledError:
                return [future for future in futures if future.cancelled()]
            except TimeoutError:
                if self._client.nthreads():
                    since = time.monotonic()
                elif time.monotonic() - since > PATIENCE:
                    raise ComputationError(
                        f"{self._address or 'the cluster'} has had no worker for {PATIENCE:g} s; finished "
                        "cases are kept. Start workers that have this version, then again with --resume."
                    ) from None


def _check_address(address: str) -> None:
    """Refuse what is no address, before Dask waits for it."""
    try:
        parts = urlsplit(address)
        sound = parts.scheme in SCHEMES and bool(parts.hostname) and parts.port is not None
    except ValueError:
        sound = False
    if not sound:
        raise InputError("scheduler", address, "is no address of a scheduler", "Give tcp://HOST:PORT of one.")


def _result(future: Any) -> Any:
    """Result of a future, or what killed its workers."""
    from distributed import CancelledError, KilledWorker

    try:
        return future.result()
    except KilledWorker as error:
        return WorkerLostError(
            f"{ALLOWED_DEATHS + 1} workers died while they ran it, the last at {error.last_worker.address}. "
            f"Perhaps it needs more than the memory of a worker."
        )
    except CancelledError:
        raise ComputationError(
            "the Dask scheduler was lost; finished cases are kept. Start again with --resume."
        ) from None
    except ImportError as error:  # what runs there raises nothing: it could not be read there
        raise ComputationError(
            f"a worker lacks what it needs ({error}). Install the same version everywhere, then again with "
            "--resume."
        ) from None
