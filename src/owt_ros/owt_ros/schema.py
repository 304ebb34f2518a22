"""Message definitions as bags hold them, from the files that every ROS 2 package installs.

Nothing is generated here: the text is that of ``share/PACKAGE/msg/NAME.msg``, with the definitions of
nested types appended, and the hash is the one that rosidl computed at build time.
"""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory

from owt_model.errors import InputError

__all__ = ["definition", "type_hash", "type_name"]

_SEPARATOR = "=" * 80
_FIELD_TYPE = re.compile(r"^\s*([A-Za-z][A-Za-z0-9_/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]")
_PRIMITIVE = re.compile(r"^(bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string)$")


def type_name(message: type[Any]) -> str:
    """Return ``package/msg/Name`` of a message class."""
    package = message.__module__.split(".")[0]
    return f"{package}/msg/{message.__name__}"


def _path(name: str, suffix: str) -> Path:
    package, _, message = name.split("/")
    try:
        path = Path(get_package_share_directory(package)) / "msg" / f"{message}{suffix}"
    except LookupError:
        raise InputError(
            "message type",
            name,
            "belongs to no installed package",
            "Run ./owt setup or source the workspace.",
        ) from None
    if not path.is_file():
        raise InputError("message type", name, f"has no definition {path}", "Run ./owt setup again.")
    return path


def _nested(text: str, package: str) -> list[str]:
    """Full names of the types that a definition uses, in order of appearance."""
    found: dict[str, None] = {}
    for line in text.splitlines():
        match = _FIELD_TYPE.match(line.split("#", 1)[0])
        if match is None or _PRIMITIVE.match(match[1]):
            continue
        parts = match[1].split("/")
        found[f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"] = None
    return list(found)


@cache
def definition(name: str) -> str:
    """Return the ``ros2msg`` schema of message `name` (``package/msg/Name``), nested types appended."""
    parts, queue, seen = [], [name], {name}
    while queue:
        current = queue.pop(0)
        package, _, message = current.split("/")
        text = _path(current, ".msg").read_text(encoding="utf-8").rstrip("\n")
        parts.append(text if current == name else f"{_SEPARATOR}\nMSG: {package}/{message}\n{text}")
        for nested in _nested(text, package):
            if nested not in seen:
                seen.add(nested)
                queue.append(nested)
    return "\n".join(parts) + "\n"


@cache
def type_hash(name: str) -> str:
    """Return the RIHS01 hash of message `name` (``package/msg/Name``), computed by rosidl at build time."""
    data = json.loads(_path(name, ".json").read_text(encoding="utf-8"))
    hashes = {entry["type_name"]: entry["hash_string"] for entry in data["type_hashes"]}
    return str(hashes[name])
