"""Outcomes of cases as bytes and back: an npz archive of the arrays and one JSON text of everything else.

Nothing is pickled, so that a result from another place can be read without trusting it. What an archive
names is looked up among the frozen dataclasses of this project.
"""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any

import numpy as np

from owt_campaign.engine import CaseOutcome
from owt_model.config import CaseConfig, parse_case
from owt_model.errors import ComputationError

__all__ = ["decode_outcome", "encode_outcome"]

TREE = "tree"
ARRAY, CLASS, CASE, TUPLE = "__array__", "__class__", "__case__", "__tuple__"
#: Packages whose dataclasses an archive may name.
PACKAGES = ("owt_model.", "owt_structure_node.", "owt_postproc.", "owt_campaign.")


def encode_outcome(outcome: CaseOutcome) -> bytes:
    """Return the outcome as the bytes of an npz archive; the same outcome gives the same bytes."""
    arrays: dict[str, np.ndarray] = {}
    tree = json.dumps(_plain(outcome, arrays), allow_nan=False)
    arrays[TREE] = np.frombuffer(tree.encode(), dtype=np.uint8)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), part.getbuffer(), zipfile.ZIP_DEFLATED, 1)
    return stream.getvalue()


def decode_outcome(data: bytes) -> CaseOutcome:
    """Read what :func:`encode_outcome` wrote.

    Raises
    ------
    ComputationError
        If it is no such archive.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        outcome = _rebuilt(json.loads(arrays.pop(TREE).tobytes().decode()), arrays)
    except (EOFError, ValueError, KeyError, TypeError, OSError, zipfile.BadZipFile, AttributeError) as error:
        raise ComputationError(f"not the result of a case ({type(error).__name__}: {error}).") from None
    if not isinstance(outcome, CaseOutcome):
        raise ComputationError("not the result of a case (another object).")
    return outcome


def _plain(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """`value` as JSON data; its arrays go into `arrays`."""
    if isinstance(value, CaseConfig):
        return {CASE: value.model_dump(mode="json")}
    if isinstance(value, np.ndarray):
        name = f"a{len(arrays)}"
        arrays[name] = value
        return {ARRAY: name}
    if isinstance(value, np.generic):
        return value.item()
    if is_dataclass(value):
        found = {field.name: _plain(getattr(value, field.name), arrays) for field in fields(value)}
        return {CLASS: f"{type(value).__module__}:{type(value).__qualname__}", "fields": found}
    if isinstance(value, dict):
        return {str(key): _plain(item, arrays) for key, item in value.items()}
    if isinstance(value, tuple):
        return {TUPLE: [_plain(item, arrays) for item in value]}
    if value is None or isinstance(value, str | int | float | bool):
        return value
    raise TypeError(f"a result cannot hold {type(value).__name__}")


def _rebuilt(data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """The object that :func:`_plain` took apart."""
    if not isinstance(data, dict):
        return data
    if ARRAY in data:
        return arrays[data[ARRAY]]
    if CASE in data:
        return parse_case(data[CASE])
    if TUPLE in data:
        return tuple(_rebuilt(item, arrays) for item in data[TUPLE])
    found = {key: _rebuilt(item, arrays) for key, item in data.get("fields", data).items() if key != CLASS}
    return _dataclass(data[CLASS])(**found) if CLASS in data else found


def _dataclass(name: str) -> type:
    """A dataclass of this project by its name."""
    module, _, qualified = name.partition(":")
    if not module.startswith(PACKAGES):
        raise ValueError(f"{name} is no class of this project")
    found = getattr(import_module(module), qualified)
    if not (isinstance(found, type) and is_dataclass(found)):
        raise ValueError(f"{name} is no dataclass")
    return found
