"""Message definitions as text: a type with everything that it is made of, as MCAP and rosbag2 keep them."""

from __future__ import annotations

import re
from collections.abc import Callable

__all__ = ["nested_types", "schema_text", "type_hash"]

_SEPARATOR = "=" * 80
_PRIMITIVE = re.compile(r"^(bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string)(<=\d+)?$")
_FIELD = re.compile(r"^(?P<type>[A-Za-z][\w/]*(<=\d+)?)(\[(<=)?\d*\])?\s+[A-Za-z]\w*")


def nested_types(text: str, package: str) -> list[str]:
    """Full names (``package/msg/Name``) of the types that the fields of a definition use, in their order."""
    found: dict[str, None] = {}
    for line in text.splitlines():
        match = _FIELD.match(line.split("#", 1)[0].strip())
        if match is None or _PRIMITIVE.match(match["type"]):
            continue
        parts = match["type"].split("/")
        found[f"{package}/msg/{parts[0]}" if len(parts) == 1 else f"{parts[0]}/msg/{parts[-1]}"] = None
    return list(found)


def schema_text(type_name: str, definition: Callable[[str], str]) -> str:
    """Definition of `type_name` followed by those of all nested types, each after a line of ``=``.

    Parameters
    ----------
    type_name : str
        ``package/msg/Name``.
    definition : callable
        Returns the text of the ``.msg`` file of a full type name.
    """
    parts, done = [], {type_name}
    queue = [type_name]
    while queue:
        name = queue.pop(0)
        package, _, short = name.split("/")
        text = definition(name).rstrip("\n")
        parts.append(text if name == type_name else f"{_SEPARATOR}\nMSG: {package}/{short}\n{text}")
        for nested in nested_types(text, package):
            if nested not in done:
                done.add(nested)
                queue.append(nested)
    return "\n".join(parts) + "\n"


def type_hash(type_name: str, schema: str) -> str:
    """RIHS01 hash of a type, as rosidl computes it, from its full schema text."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema, type_name))
    return str(store.hash_rihs01(type_name))
