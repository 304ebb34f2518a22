"""Many cases on Dask or in this process: records as the cases are done, a failing one stops no other.

The outcome of a case depends on its content alone, not on the workers, their number or the order. Each worker
is a process with one thread, and it holds one case and at most :data:`~owt_campaign.worker.MODELS` prepared
structures at a time; a worker that takes more than its memory is started again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from owt_campaign.clusters import CLUSTERS, cluster_label
from owt_campaign.dask_pool import DaskPool, Done, InProcess, Pool, WorkerLostError
from owt_campaign.engine import CaseOutcome, model_key
from owt_campaign.identity import case_key, code_hash, structure_hash
from owt_campaign.result_file import decode_outcome
from owt_campaign.store import ResultStore
from owt_campaign.worker import WorkerResult, compute_basis, compute_case
from owt_model.config import CaseConfig
from owt_model.errors import InputError, OwtError

__all__ = ["CaseRecord", "check_workers", "run_cases"]


@dataclass(frozen=True)
class CaseRecord:
    """What became of one case.

    Attributes
    ----------
    index : int
        Place in the cases given.
    case : CaseConfig
        As given.
    key : str
        Content hash: what the outcome depends on.
    status : "done" or "failed"
    message : str
        Why it failed.
    reused : bool
        Whether the outcome was found in the store.
    seconds, cpu_seconds, peak_memory_mib : float
        What it took, in its worker; zero where reused.
    data : bytes
        The outcome as result_file.py encodes it.
    """

    index: int
    case: CaseConfig
    key: str
    status: Literal["done", "failed"]
    message: str = ""
    reused: bool = False
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak_memory_mib: float = 0.0
    data: bytes = field(default=b"", repr=False)

    @cached_property
    def outcome(self) -> CaseOutcome | None:
        """Result of the case; None if it failed."""
        return decode_outcome(self.data) if self.status == "done" else None


@dataclass(frozen=True)
class _Job:
    """A case to compute, with what its cluster is computed from."""

    index: int
    case: CaseConfig
    key: str
    structure: str
    cluster: str


def run_cases(
    cases: Sequence[CaseConfig],
    *,
    workers: int,
    scheduler: str | None = None,
    on_done: Callable[[CaseRecord], None] | None = None,
    cluster: str = "spec",
    keep: Sequence[str] = (),
    store: ResultStore | None = None,
    on_start: Callable[[str], None] | None = None,
) -> Iterator[CaseRecord]:
    """Run cases; yield a record of each as it is done.

    Parameters
    ----------
    cases : sequence of CaseConfig
        The cases.
    workers : int
        Processes of a cluster on this machine; 0 computes in this process, one case after the other.
    scheduler : str, optional
        Address of a Dask scheduler, like ``tcp://host:8786``, whose workers run this code; `workers` is then
        ignored.
    on_done : callable, optional
        Called with each record before it is yielded.
    cluster : str
        Cases that share load vectors: spec, dir, hs or tot (:mod:`owt_campaign.clusters`); cases of another
        structure or wave order are never in one cluster. A sea state counts once, by its first case.
    keep : sequence of str
        Series to keep (:mod:`owt_campaign.kept_series`).
    store : ResultStore, optional
        Where finished results are looked for, and kept.
    on_start : callable, optional
        Called with one line that says where the work is done, the dashboard's address in it.

    Yields
    ------
    CaseRecord
        First what failed before it began or is in the store, then the others as they are done.

    Raises
    ------
    InputError
        If an argument is refused, or there is no scheduler at the address.
    ComputationError
        If the scheduler is lost; what is in the store stays.
    """
    if cluster not in CLUSTERS:
        raise InputError("cluster", cluster, f"must be one of {', '.join(CLUSTERS)}", "Use spec.")
    check_workers(workers)
    jobs, members = [], _Clusters(cases, cluster)
    structures: dict[str, str] = {}
    for index, case in enumerate(cases):
        found = _begin(index, case, members, structures, tuple(keep), store)
        if isinstance(found, _Job):
            jobs.append(found)
            continue
        if on_done is not None:
            on_done(found)
        yield found
    if not jobs:
        return
    with _pool(workers, scheduler) as pool:
        if on_start is not None:
            on_start(pool.description)
        for done in pool.run(_submissions(pool, jobs, members, tuple(keep))):
            record = _record(done, store)
            if on_done is not None:
                on_done(record)
            yield record


def check_workers(workers: int, scheduler: str | None = None) -> None:
    """Make sure that there is who can compute, before anything is begun or removed.

    Raises
    ------
    InputError
        If the number is refused, or there is no scheduler at the address.
    """
    if workers < 0:
        raise InputError("workers", workers, "must be 0 or more", "0 computes in this process.")
    if scheduler is not None:
        with DaskPool(workers, scheduler):
            pass


class _Clusters:
    """The cases whose loads give the vectors of each cluster."""

    def __init__(self, cases: Sequence[CaseConfig], method: str) -> None:
        self._method = method
        self._members: dict[str, dict[str, CaseConfig]] = {}
        self._identities: dict[tuple[str, str], str] = {}
        if method == "spec":
            return
        for case in cases:
            sea = case.model_dump_json(include={"sea_state": {"hs_m", "tp_s", "direction_deg"}})
            sea = sea if case.sea_state is not None else case.model_dump_json()
            try:
                self._members.setdefault(self.name(case), {}).setdefault(sea, case)
            except InputError:  # becomes the message of the case itself
                continue

    def name(self, case: CaseConfig) -> str:
        """Cluster of a case; empty where it has its own load vectors."""
        label = cluster_label(case, self._method)
        return f"{label} order {case.wave.order} {model_key(case)}" if label else ""

    def cases(self, name: str) -> list[CaseConfig]:
        """The cases that give its vectors."""
        return list(self._members[name].values())

    def identity(self, name: str, structure: str) -> str:
        """What its vectors depend on."""
        if not name:
            return ""
        known = self._identities.get((name, structure))
        if known is None:
            keys = " ".join(case_key(case, structure) for case in self.cases(name))
            known = self._identities[name, structure] = hashlib.sha256(keys.encode()).hexdigest()
        return known


def _begin(
    index: int,
    case: CaseConfig,
    members: _Clusters,
    structures: dict[str, str],
    keep: tuple[str, ...],
    store: ResultStore | None,
) -> _Job | CaseRecord:
    """What is to be computed of a case; or its record, where it is in the store or refused already."""
    key = ""
    try:
        name, model = members.name(case), case.structure.model_dump_json()
        if model not in structures:
            structures[model] = structure_hash(case)
        structure = structures[model]
        key = case_key(case, structure, basis=members.identity(name, structure), keep=keep)
    except OwtError as error:
        return CaseRecord(index, case, key, "failed", " ".join(str(error).split()))
    data = None if store is None else store.get(key)
    if data is not None:
        return CaseRecord(index, case, key, "done", reused=True, data=data)
    return _Job(index, case, key, structure, name)


def _pool(workers: int, scheduler: str | None) -> Pool:
    """Who computes."""
    return InProcess() if scheduler is None and workers == 0 else DaskPool(workers, scheduler)


def _submissions(
    pool: Pool, jobs: Sequence[_Job], members: _Clusters, keep: tuple[str, ...]
) -> Iterator[tuple[_Job, Callable[..., WorkerResult], tuple[object, ...]]]:
    """The calls to make, in an order in which few clusters are under way at a time."""
    name, basis = "", None
    for job in sorted(jobs, key=lambda job: (job.cluster, job.index)):
        if job.cluster != name:
            name = job.cluster
            basis = pool.shared(compute_basis, members.cases(name), job.structure) if name else None
        yield job, compute_case, (job.case, job.structure, keep, basis)


def _record(done: Done[_Job, WorkerResult], store: ResultStore | None) -> CaseRecord:
    """Record of a computed case, kept first."""
    job, result = done.job, done.result
    if isinstance(result, WorkerLostError):
        return CaseRecord(job.index, job.case, job.key, "failed", str(result))
    message = result.message
    if not message and result.code != code_hash():
        message = "its worker runs other code than this process. Install the same version everywhere."
    if message:
        return CaseRecord(job.index, job.case, job.key, "failed", message, seconds=result.seconds)
    if store is not None:
        store.put(job.key, result.data)
    return CaseRecord(
        job.index,
        job.case,
        job.key,
        "done",
        seconds=result.seconds,
        cpu_seconds=result.cpu_seconds,
        peak_memory_mib=result.peak_memory_mib,
        data=result.data,
    )
