"""What a case asks for, in the words of the case file, as far as it differs from the defaults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from owt_model.config import SEA_SOURCES, CaseConfig

__all__ = ["case_facts"]

#: Parts of a case that other tables of the report show, or that do not change a result.
ELSEWHERE = ("points_m", "stream")
#: Numbers of a list that are still written out.
SHORT = 6


def _flat(prefix: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Dotted names and values."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(f"{prefix}.{key}" if prefix else str(key), inner)
    else:
        yield prefix, value


def _numbers(value: Any) -> int:
    return sum(map(_numbers, value)) if isinstance(value, list | tuple) else 1


def _shown(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return str(value) if _numbers(value) <= SHORT else f"{len(value)} entries"
    return "on" if value is True else "off" if value is False else value


def case_facts(case: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Key and value of everything in `case` that is not the default, and of all that gives its sea.

    Parameters
    ----------
    case : mapping
        A case file as plain data; keys that it lacks have their defaults.
    """
    default = dict(_flat("", CaseConfig().model_dump(mode="json")))
    source = [name for name in SEA_SOURCES if case.get(name) is not None]
    return [
        (name, _shown(value))
        for name, value in _flat("", {key: part for key, part in case.items() if key not in ELSEWHERE})
        if value is not None
        and (value != default.get(name) or (source and name.split(".")[0] == source[0] != "sea_state"))
    ]
