"""A few threads for kernels and transforms, which release the interpreter lock."""

from __future__ import annotations

from owt_model.parallel import map_threads, slices, thread_count

__all__ = ["map_threads", "slices", "thread_count"]
