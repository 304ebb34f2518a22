"""Messages recorded with an older definition of their type, in the one that is installed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from owt_model.errors import InputError
from owt_postproc.bag_source import RecordedTopic
from owt_postproc.message_schema import types_of
from owt_ros import schema

__all__ = ["to_installed"]


def to_installed(topic: RecordedTopic) -> Callable[[bytes], bytes] | None:
    """Return what turns the recorded bytes into those of the installed definition; None if they are the same.

    Fields that the recording does not know are empty, or zero.

    Raises
    ------
    InputError
        If the installed definition differs in more than additional fields.
    """
    if not topic.type_hash or topic.type_hash == schema.type_hash(topic.type_name):
        return None
    old, new = (
        _store(topic.type_name, topic.schema),
        _store(topic.type_name, schema.definition(topic.type_name)),
    )
    known, wanted = (dict(store.fielddefs[topic.type_name][1]) for store in (old, new))
    nested = set(old.fielddefs) - {topic.type_name}
    if not (
        known.items() <= wanted.items() and all(old.fielddefs[n] == new.fielddefs.get(n) for n in nested)
    ):
        raise InputError(
            "topics",
            topic.name,
            f"was recorded with another definition of {topic.type_name} than the one installed",
            "Use the version that made the bag, or select others by --topics.",
        )
    added = {name: _empty(new, kind) for name, kind in wanted.items() if name not in known}
    make = new.types[topic.type_name]

    def turn(data: bytes) -> bytes:
        content = old.deserialize_cdr(data, topic.type_name)
        values = {name: getattr(content, name) for name in known}
        return bytes(new.serialize_cdr(make(**values, **added), topic.type_name))

    return turn


def _store(type_name: str, text: str) -> Any:
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.EMPTY)
    store.register(types_of(type_name, text))
    return store


def _empty(store: Any, kind: Any) -> Any:
    """Value of a field that was not recorded."""
    from rosbags.interfaces import Nodetype

    node, what = kind
    if node == Nodetype.NAME:
        return store.types[what](**{name: _empty(store, inner) for name, inner in store.fielddefs[what][1]})
    if node == Nodetype.BASE:
        return {"string": "", "wstring": "", "bool": False}.get(what[0], 0)
    (inner, of), length = what
    size = length if node == Nodetype.ARRAY else 0
    if inner == Nodetype.BASE and of[0] not in ("string", "wstring"):
        return np.zeros(size, dtype={"octet": "uint8", "byte": "uint8", "char": "uint8"}.get(of[0], of[0]))
    return [_empty(store, (inner, of)) for _ in range(size)]
