"""Serialised messages whose bytes depend on their content alone.

CDR aligns numbers, and Fast DDS leaves what happened to be in memory in the gaps, and sometimes behind the
last field. Two runs of one case then differ in bytes that mean nothing, and strict readers refuse the rest.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

from rosidl_parser.definition import (
    AbstractSequence,
    AbstractString,
    Array,
    BasicType,
    NamespacedType,
)

from owt_model.errors import ComputationError

__all__ = ["canonical"]

#: Bytes of the encapsulation, from whose end alignment counts.
_HEAD = 4
_SIZE = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1,
    "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float": 4,
    "int64": 8, "uint64": 8, "double": 8,
}  # fmt: skip

#: Moves past a value: takes bytes and position, returns the position behind it; clears the gaps on its way.
_Walk = Callable[[bytearray, int], int]


def canonical(message: Any, cdr: bytes) -> bytes:
    """Return a serialised message of class `message` with zeros in its gaps and nothing behind its end.

    Raises
    ------
    ComputationError
        If the bytes are no such message.
    """
    data = bytearray(cdr)
    try:
        end = _message(message)(data, _HEAD)
    except (struct.error, IndexError):
        end = len(data) + 1
    if end > len(data) or not data[1] & 1:
        raise ComputationError(f"{len(cdr)} bytes are no message of type {message.__name__}")
    return bytes(data[:end])


def _aligned(data: bytearray, position: int, size: int) -> int:
    """Next position that a number of `size` bytes may stand at; the gap before it is cleared."""
    gap = -(position - _HEAD) % size
    if gap:
        data[position : position + gap] = bytes(gap)
    return position + gap


def _count(data: bytearray, position: int) -> tuple[int, int]:
    """Read a length; return it and the position behind it."""
    position = _aligned(data, position, 4)
    (count,) = struct.unpack_from("<I", data, position)
    return count, position + 4


@cache
def _message(message: Any) -> _Walk:
    """Walk of all fields of a message class."""
    walks = [_walk(kind) for kind in message.SLOT_TYPES]

    def walk(data: bytearray, position: int) -> int:
        for field in walks:
            position = field(data, position)
        return position

    return walk


def _walk(kind: Any) -> _Walk:
    """Walk of one field type."""
    if isinstance(kind, BasicType):
        size = _SIZE[kind.typename]
        return lambda data, position: _aligned(data, position, size) + size
    if isinstance(kind, AbstractString):
        return _past_string
    if isinstance(kind, NamespacedType):
        module = import_module(".".join(kind.namespaces))
        return _message(getattr(module, kind.name))
    assert isinstance(kind, Array | AbstractSequence)
    return _sequence(kind)


def _past_string(data: bytearray, position: int) -> int:
    count, position = _count(data, position)
    if count and position + count <= len(data):
        data[position + count - 1] = 0  # readers do not look at the terminator
    return position + count


def _sequence(kind: Any) -> _Walk:
    """Walk of an array or a sequence: numbers are passed in one step."""
    fixed = kind.size if isinstance(kind, Array) else None
    size = _SIZE[kind.value_type.typename] if isinstance(kind.value_type, BasicType) else 0
    entry = _walk(kind.value_type)

    def walk(data: bytearray, position: int) -> int:
        count, position = (fixed, position) if fixed is not None else _count(data, position)
        if size:
            return _aligned(data, position, size) + count * size if count else position
        for _ in range(count):
            if position > len(data):
                raise IndexError(position)
            position = entry(data, position)
        return position

    return walk
