"""Message definitions kept as text, and their RIHS01 hash, without ROS."""

from __future__ import annotations

from typing import Any

__all__ = ["type_hash", "types_of"]


def types_of(type_name: str, schema: str) -> dict[str, Any]:
    """Type definitions of the rosbags library from a full schema (nested types after lines of ``=``)."""
    from rosbags.typesys import get_types_from_msg

    return dict(get_types_from_msg(schema, type_name))


def type_hash(type_name: str, schema: str) -> str:
    """RIHS01 hash of a type, the one that rosidl computes, from its full schema text."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.EMPTY)
    store.register(types_of(type_name, schema))
    return str(store.hash_rihs01(type_name))
