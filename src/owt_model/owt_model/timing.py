"""When a sample of a stream is: time stamps in ns from indices and back, the same on both sides of a wire.

Time steps count in whole picoseconds, so that stamps do not drift over a long record.
"""

from __future__ import annotations

__all__ = ["sample_index", "sample_time_ns"]


def _picoseconds(dt: float) -> int:
    return round(dt * 1e12)


def sample_time_ns(index: int, dt: float) -> int:
    """Return the simulated time in ns of sample `index` of a stream with step `dt` in s, exact to the ns."""
    return round(index * _picoseconds(dt) / 1e3)


def sample_index(ns: int, dt: float) -> int:
    """Return the index of the sample at simulated time `ns` in ns; the inverse of :func:`sample_time_ns`."""
    return round(ns * 1e3 / _picoseconds(dt))
