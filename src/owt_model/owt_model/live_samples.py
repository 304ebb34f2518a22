"""Samples that arrive one by one, jittered, late, twice or not at all, read out once on a grid of times.

A sample that no message gives is never made up silently: it is an error, or it is filled as the case says,
marked and counted. Which messages a read-out uses depends on their stamps alone as long as none comes later
than `reorder_ns` after one with a higher stamp, and nothing times out.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from typing import SupportsInt

import numpy as np
from jaxtyping import Bool, Float, Int

from owt_model.errors import ComputationError

__all__ = ["LiveRules", "SampleBuffer"]

NS = 1e9


@dataclass(frozen=True)
class LiveRules:
    """What is done between messages, and without them.

    Attributes
    ----------
    step : bool
        Between two messages the value of the earlier one; else a line.
    missing : str
        ``error``, ``hold`` the value before, ``zero``, or ``interpolate`` across whatever gap.
    max_gap_ns : int, optional
        Longest time between two messages that counts as covered; any if None.
    reorder_ns : int
        Simulated time by which a message may follow later ones and surely still counts.
    """

    step: bool = False
    missing: str = "error"
    max_gap_ns: int | None = None
    reorder_ns: int = 0

    @classmethod
    def of(cls, *, missing: str, max_gap_s: float | None, reorder_s: float, step: bool = False) -> LiveRules:
        """Rules with times in s."""
        gap = None if max_gap_s is None else round(max_gap_s * NS)
        return cls(step=step, missing=missing, max_gap_ns=gap, reorder_ns=round(reorder_s * NS))


@dataclass
class _Count:
    """Messages of one kind, and the stamps that they span."""

    number: int = 0
    first_ns: int = 0
    last_ns: int = 0

    def add(self, first_ns: int, last_ns: int | None = None, number: int = 1) -> None:
        last_ns = first_ns if last_ns is None else last_ns
        self.first_ns = min(self.first_ns, first_ns) if self.number else first_ns
        self.last_ns = max(self.last_ns, last_ns) if self.number else last_ns
        self.number += number


class SampleBuffer:
    """Stamped samples in order of their stamps, whatever the order of their arrival.

    Parameters
    ----------
    what : str
        What a sample is called in messages.
    width : int
        Values per sample.
    rules : LiveRules
        What is done between messages, and without them.
    """

    def __init__(self, what: str, width: int, rules: LiveRules) -> None:
        self._what, self._width, self.rules = what, width, rules
        self._time: list[int] = []
        self._value: list[Float[np.ndarray, " value"]] = []
        self._read: int | None = None
        self.newest_ns: int | None = None
        self._counts = {kind: _Count() for kind in ("filled", "late", "repeated", "refused")}
        #: Numbers over the whole stream: samples filled, messages dropped.
        self.totals = dict.fromkeys(self._counts, 0)

    def add(self, time_ns: int, value: Float[np.ndarray, " value"], *, refusal: str = "") -> None:
        """Take a message, in any order.

        Parameters
        ----------
        time_ns : int
            Its stamp in simulated time, in ns.
        value : float array [value]
            Its values.
        refusal : str
            Why it cannot be one of these samples; empty if it can.

        Raises
        ------
        ComputationError
            Where a missing sample is an error: if the message cannot be a sample, comes after its time was
            counted, or contradicts an earlier one.
        """
        if not np.isfinite(value).all():
            refusal = "holds NaN or inf"
        if refusal:
            self._drop("refused", time_ns, refusal)
            return
        self.newest_ns = time_ns if self.newest_ns is None else max(self.newest_ns, time_ns)
        if self._read is not None and time_ns <= self._read:
            self._drop("late", time_ns, f"comes after the load up to {_seconds(self._read)} was counted")
            return
        at = bisect_left(self._time, time_ns)
        if at < len(self._time) and self._time[at] == time_ns:
            same = bool(np.array_equal(self._value[at], value))
            self._drop("repeated", time_ns, "" if same else "comes twice, with different values")
            return
        self._time.insert(at, time_ns)
        self._value.insert(at, np.array(value, dtype=float))

    def _drop(self, kind: str, time_ns: int, error: str) -> None:
        if error and self.rules.missing == "error":
            raise ComputationError(f"{self._what} at {_seconds(time_ns)} {error}")
        self._counts[kind].add(time_ns)
        self.totals[kind] += 1

    def reach(self, time_ns: int) -> bool:
        """Tell whether all samples up to a time are known, or known to be missing."""
        return self.newest_ns is not None and self.newest_ns >= time_ns + self.rules.reorder_ns

    def take(
        self, times: Int[np.ndarray, " sample"], *, forced: bool = False
    ) -> tuple[Float[np.ndarray, "sample value"], Bool[np.ndarray, " sample"]]:
        """Samples at ascending times in ns, later than all taken before, and which of them are made up.

        Parameters
        ----------
        times : int array [sample]
            Simulated times in ns.
        forced : bool
            Take them although they are not reached; what has not come is missing.

        Raises
        ------
        ComputationError
            If a sample is missing and that is an error, or if they are not reached.
        """
        needed = bisect_right(self._time, int(times[-1])) + 1  # one message past the last time
        known = np.array(self._time[:needed], dtype=np.int64)
        before = np.searchsorted(known, times, side="right") - 1
        after = before + 1
        exact = (before >= 0) & (known[np.maximum(before, 0)] == times) if known.size else before >= 0
        between = (before >= 0) & (after < known.size)
        left, right = np.maximum(before, 0), np.minimum(after, max(known.size - 1, 0))
        gap = known[right] - known[left] if known.size else np.zeros_like(times)
        limit = self.rules.max_gap_ns
        covered = exact | (between if limit is None else between & (gap <= limit))
        filled = ~covered
        missing = self.rules.missing
        if (filled.any() and missing == "error") or not (forced or self.reach(int(times[-1]))):
            raise ComputationError(self._lack(times, filled, known))
        out = np.zeros((times.size, self._width))
        if known.size:
            value = np.array(self._value[:needed])
            part = (times - known[left]) / np.maximum(gap, 1)
            line = (covered & ~exact & (not self.rules.step)) | (
                filled & between & (missing == "interpolate")
            )
            out = value[left] + np.where(line, part, 0.0)[:, None] * (value[right] - value[left])
            if missing == "zero":
                out[filled] = 0.0
            kept = max(int(before[-1]), 0)  # what comes next lies after the last time
            del self._time[:kept], self._value[:kept]
        self._read = int(times[-1])
        if filled.any():
            at = times[filled]
            self._counts["filled"].add(int(at[0]), int(at[-1]), at.size)
            self.totals["filled"] += at.size
        return out, filled

    def _lack(
        self,
        times: Int[np.ndarray, " sample"],
        filled: Bool[np.ndarray, " sample"],
        known: Int[np.ndarray, " m"],
    ) -> str:
        span = f"{self._what}: asked for {_seconds(times[0])} to {_seconds(times[-1])}"
        if not known.size or known[0] > times[0] or not filled.any():
            have = f"{_seconds(self._time[0])} to {_seconds(self._time[-1])}" if self._time else "nothing"
            return f"{span}, known is {have}; its first message must be stamped 0"
        first = int(times[filled][0])
        at = int(np.searchsorted(known, first, side="right"))
        until = f"and {_seconds(known[at])}" if at < known.size else "and what comes next"
        limit = (
            "" if self.rules.max_gap_ns is None else f", more than max_gap_s = {self.rules.max_gap_ns / NS:g}"
        )
        return f"{span}, no message between {_seconds(known[at - 1])} {until}{limit}"

    def take_counts(self) -> list[tuple[str, int, float, float]]:
        """What was made up or dropped since the last call: kind, number, first and last time in s.

        Kinds are ``filled`` (samples made up), ``late``, ``repeated`` and ``refused`` (messages dropped).
        """
        found = [
            (kind, count.number, count.first_ns / NS, count.last_ns / NS)
            for kind, count in self._counts.items()
            if count.number
        ]
        self._counts = {kind: _Count() for kind in self._counts}
        return found


def _seconds(time_ns: SupportsInt) -> str:
    return f"{int(time_ns) * 1e-9:.9g} s"
