"""What a Dask worker runs: one case, or the load vectors of a cluster of cases; nothing here raises.

A worker keeps the models that it has prepared, so that cases which share one reduce the structure once.
"""

from __future__ import annotations

import hashlib
import resource
import threading
import time
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

from owt_campaign.engine import (
    CaseOutcome,
    SharedModel,
    cluster_basis,
    evaluate_case,
    model_key,
    prepare_model,
)
from owt_campaign.identity import code_hash
from owt_campaign.result_file import encode_outcome
from owt_model.config import CaseConfig
from owt_model.contracts import LoadBasis
from owt_model.errors import OwtError

__all__ = ["MODELS", "ClusterBasis", "WorkerResult", "compute_basis", "compute_case"]

#: Prepared models that a worker holds; the one that was not used for longest gives way.
MODELS = 4

_models: OrderedDict[tuple[str, str, str], SharedModel] = OrderedDict()
#: A worker of another scheduler may have several threads.
_lock = threading.RLock()


@dataclass(frozen=True)
class ClusterBasis:
    """Load vectors of a cluster of cases, or why there are none."""

    token: str
    basis: LoadBasis | None
    message: str = ""


@dataclass(frozen=True)
class WorkerResult:
    """What became of one case: `data` as result_file.py encodes it, or a message."""

    data: bytes
    message: str
    seconds: float
    cpu_seconds: float
    peak_memory_mib: float
    code: str


def compute_case(
    case: CaseConfig,
    structure: str,
    keep: tuple[str, ...],
    cluster: ClusterBasis | None = None,
) -> WorkerResult:
    """Evaluate one case; whatever goes wrong becomes the message.

    Parameters
    ----------
    case : CaseConfig
        The case.
    structure : str
        Hash of the content of its structure.
    keep : tuple of str
        Series to keep.
    cluster : ClusterBasis, optional
        Load vectors that it shares with others.
    """
    start, used, data, message = time.perf_counter(), time.process_time(), b"", ""
    if cluster is not None and cluster.message:
        message = f"load vectors of its cluster: {cluster.message}"
    else:
        try:
            data = encode_outcome(_evaluate(case, structure, keep, cluster))
        except (Exception, MemoryError) as error:
            message = _message(error)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    spent = time.perf_counter() - start, time.process_time() - used
    return WorkerResult(data, message, *spent, peak, code_hash())


def compute_basis(cases: Sequence[CaseConfig], structure: str) -> ClusterBasis:
    """Load vectors that `cases` share; the token tells them from others."""
    try:
        basis = cluster_basis(cases, _prepared(cases[0], structure, None))
    except (Exception, MemoryError) as error:
        return ClusterBasis("", None, _message(error))
    return ClusterBasis(hashlib.sha256(basis.vectors.tobytes()).hexdigest(), basis)


def _evaluate(
    case: CaseConfig, structure: str, keep: tuple[str, ...], cluster: ClusterBasis | None
) -> CaseOutcome:
    return evaluate_case(case, _prepared(case, structure, cluster), keep=keep)


def _prepared(case: CaseConfig, structure: str, cluster: ClusterBasis | None) -> SharedModel:
    """The model of a case, prepared by the first case that needs it."""
    key = (model_key(case), structure, "" if cluster is None else cluster.token)
    with _lock:
        model = _models.get(key)
        if model is None:
            if cluster is None:
                model = prepare_model(case)
            else:
                model = _prepared(case, structure, None).with_basis(case, cluster.basis)
            _models[key] = model
            while len(_models) > MODELS:
                _models.popitem(last=False)
        _models.move_to_end(key)
    return model


def _message(error: BaseException) -> str:
    """One line that says what went wrong."""
    text = " ".join(str(error).split())
    return text if isinstance(error, OwtError) else f"{type(error).__name__}: {text}"
