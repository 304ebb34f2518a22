"""Heads and arrays of messages: stamps, block heads (also straight from CDR bytes), flat arrays with a shape.

The helpers of :mod:`owt_ros.convert` and :mod:`owt_ros.decode`; no ROS is imported.
"""

from __future__ import annotations

import struct
from array import array
from dataclasses import dataclass
from typing import Any

import numpy as np

from owt_model.errors import StreamError
from owt_model.timing import sample_index, sample_time_ns

__all__ = [
    "NO_MEMBER",
    "Head",
    "doubles",
    "flat_array",
    "head_of",
    "indices",
    "peek_head",
    "peek_stamp",
    "read_doubles",
    "read_flags",
    "time_ns",
    "uint32s",
]

#: Member of an element that belongs to none (the tower).
NO_MEMBER = 2**32 - 1


def time_ns(time: Any) -> int:
    """Return a time message in ns."""
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


@dataclass(frozen=True)
class Head:
    """What every data message starts with."""

    time_ns: int
    sequence: int
    dt: float
    samples: int
    last: bool

    @property
    def start(self) -> int:
        """Index of the first sample in the stream."""
        return sample_index(self.time_ns, self.dt)

    @property
    def end_ns(self) -> int:
        """Simulated time in ns of the sample that follows the last one of this block."""
        return sample_time_ns(self.start + self.samples, self.dt)


def _checked(head: Head, kind: str) -> Head:
    if not (1e-9 <= head.dt <= 1e6) or head.samples < 1:
        raise StreamError(
            f"{kind} {head.sequence}: dt = {head.dt} s with {head.samples} samples is no block of a stream"
        )
    return head


def head_of(message: Any) -> Head:
    """Return the head of a data message.

    Raises
    ------
    StreamError
        If time step or number of samples cannot be.
    """
    head = Head(
        time_ns(message.header.stamp),
        int(message.sequence),
        float(message.dt),
        int(message.samples),
        bool(message.last),
    )
    return _checked(head, _kind(message))


def peek_head(cdr: bytes, kind: str) -> Head:
    """Return the head of a serialised data message of type `kind` without reading the rest.

    Raises
    ------
    StreamError
        If the bytes hold no such head.
    """
    try:
        order = "<" if cdr[1] & 1 else ">"
        sec, nanosec, length = struct.unpack_from(f"{order}iII", cdr, 4)
        # alignment counts from the end of the four bytes of encapsulation
        position = 4 + (12 + length + 7) // 8 * 8
        sequence, dt, samples, last = struct.unpack_from(f"{order}QdI?", cdr, position)
    except (struct.error, IndexError):
        raise StreamError(f"{kind}: {len(cdr)} bytes are no such message") from None
    return _checked(Head(sec * 1_000_000_000 + nanosec, sequence, dt, samples, last), kind)


def peek_stamp(cdr: bytes) -> int:
    """Return the time in ns that a serialised message starts with (a header, or a clock).

    Raises
    ------
    StreamError
        If the bytes are too few.
    """
    try:
        sec, nanosec = struct.unpack_from("<iI" if cdr[1] & 1 else ">iI", cdr, 4)
    except (struct.error, IndexError):
        raise StreamError(f"{len(cdr)} bytes are no message with a time") from None
    return int(sec) * 1_000_000_000 + int(nanosec)


def _kind(message: Any) -> str:
    return type(message).__name__.split("__")[-1].lstrip("_")


def flat_array(code: str, dtype: Any, values: Any) -> array[Any]:
    """Return `values` flattened in C order as a message array."""
    out: array[Any] = array(code)
    flat = np.ascontiguousarray(values, dtype=dtype).reshape(-1)
    if flat.size:
        out.frombytes(flat.data.cast("B"))
    return out


def doubles(values: Any) -> array[Any]:
    """Return a ``float64[]`` field."""
    return flat_array("d", np.float64, values)


def uint32s(values: Any) -> array[Any]:
    """Return a ``uint32[]`` field."""
    return flat_array("I", np.uint32, values)


def read_doubles(message: Any, name: str, *shape: int) -> np.ndarray:
    """Return field `name` as a float64 array of `shape`, without copying; one entry of -1 is free."""
    data = getattr(message, name)
    flat = np.frombuffer(data, dtype=np.float64) if len(data) else np.zeros(0)
    known = int(np.prod([n for n in shape if n >= 0], dtype=np.int64))
    fits = flat.size % known == 0 if -1 in shape and known else flat.size == known
    if not fits:
        wanted = ", ".join("*" if n < 0 else str(n) for n in shape)
        raise StreamError(f"{_place(message)}: {name} has {flat.size} values, not those of [{wanted}]")
    if -1 in shape and known == 0:
        return np.zeros([max(n, 0) for n in shape])
    return flat.reshape(shape)


def read_flags(message: Any, name: str, size: int) -> np.ndarray:
    """Return ``uint8[]`` field `name` as `size` booleans; of an empty field all are false."""
    flags = np.array(getattr(message, name), dtype=np.uint8) != 0
    if flags.size not in (0, size):
        raise StreamError(f"{_place(message)}: {name} has {flags.size} values, not those of [{size}]")
    return flags if flags.size else np.zeros(size, dtype=bool)


def read_integers(message: Any, name: str, *shape: int) -> np.ndarray:
    """Return an integer field as an index array of `shape`."""
    values = indices(getattr(message, name))
    if values.size != int(np.prod(shape, dtype=np.int64)):
        wanted = ", ".join(map(str, shape))
        raise StreamError(f"{_place(message)}: {name} has {values.size} values, not those of [{wanted}]")
    return values.reshape(shape)


def _place(message: Any) -> str:
    sequence = getattr(message, "sequence", None)
    return _kind(message) if sequence is None else f"{_kind(message)} {int(sequence)}"


def indices(data: Any) -> np.ndarray:
    """Return an integer field as an index array."""
    return np.array(data, dtype=np.int64)
