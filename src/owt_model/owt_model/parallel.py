"""A few threads for kernels and transforms, which release the interpreter lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

__all__ = ["map_threads", "slices", "thread_count"]

Item = TypeVar("Item")
Result = TypeVar("Result")
MAX_THREADS = 8


def thread_count() -> int:
    """Threads to use: the processors this process may run on, or ``OWT_THREADS``, at most 8."""
    asked = os.environ.get("OWT_THREADS", "")
    available = int(asked) if asked.isdigit() else len(os.sched_getaffinity(0))
    return max(1, min(available, MAX_THREADS))


def slices(size: int, step: int) -> list[slice]:
    """Consecutive ranges of at most `step` that cover `size`."""
    return [slice(i, min(i + step, size)) for i in range(0, size, step)]


def map_threads(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Apply `function` to every item, results in order; they do not depend on the number of threads."""
    items = list(items)
    threads = min(thread_count(), len(items))
    if threads <= 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))
