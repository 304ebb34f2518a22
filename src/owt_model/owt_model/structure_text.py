"""A structure as text that goes into a bag, so that the bag needs no other file."""

from __future__ import annotations

import yaml

from owt_model.structure import Structure, parse_structure

__all__ = ["structure_from_text", "structure_text"]


def structure_text(structure: Structure) -> str:
    """Return a structure as YAML, equal in all its fields when it is read again."""
    data = structure.model_dump(mode="json", exclude_none=True)
    return str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True))


def structure_from_text(text: str, *, source: str) -> Structure:
    """Read what :func:`structure_text` gave.

    Raises
    ------
    InputError
        If it is not a valid structure.
    """
    return parse_structure(yaml.safe_load(text), source=source)
