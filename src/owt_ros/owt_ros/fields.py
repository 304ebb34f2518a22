"""A configuration model seen as a flat table of ROS parameters, and back. No ROS in here.

A nested field becomes a dotted name (``sea_state.hs_m``), a list of points a flat list of numbers. A
field that may be null is a parameter that may be unset.
"""

from __future__ import annotations

import difflib
import json
import types
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from owt_model.config import SEA_SOURCES, CaseConfig, parse_case
from owt_model.errors import InputError
from owt_model.validation import input_error

__all__ = ["Leaf", "case_from_values", "case_values", "leaves", "model_from_values", "unknown_parameter"]

Model = TypeVar("Model", bound=BaseModel)


@dataclass(frozen=True)
class Leaf:
    """One parameter.

    Attributes
    ----------
    kind : str
        ``bool``, ``int``, ``float``, ``str``, ``floats``, ``json`` for a table by name, as text, or, where a
        number or a list will do, ``any``.
    width : int
        Numbers per row of a list of points; 0 otherwise.
    minimum, maximum : float, int or None
        Limits; ``above`` and ``below`` tell that they are excluded.
    """

    name: str
    kind: str
    optional: bool
    default: Any
    description: str
    width: int = 0
    minimum: float | int | None = None
    maximum: float | int | None = None
    above: bool = False
    below: bool = False
    choices: tuple[Any, ...] = ()


def _members(annotation: Any) -> tuple[Any, ...]:
    """Alternatives of a type, without null."""
    if get_origin(annotation) not in (Union, types.UnionType):
        return (annotation,)
    entries = (entry for entry in get_args(annotation) if entry is not type(None))
    return tuple(get_args(entry)[0] if get_origin(entry) is Annotated else entry for entry in entries)


def _row_width(member: Any) -> int:
    """Numbers per row where a type is a list of rows; 0 elsewhere."""
    entry = get_args(member)[0] if get_origin(member) is tuple else None
    return len(get_args(entry)) if get_origin(entry) is tuple else 0


def _kind(members: tuple[Any, ...]) -> tuple[str, int, tuple[Any, ...]]:
    """Kind, row width and choices of a leaf's type."""
    if len(members) > 1:
        return "any", max(_row_width(member) for member in members), ()
    (member,) = members
    if get_origin(member) is Literal:
        choices = get_args(member)
        return type(choices[0]).__name__, 0, choices
    if get_origin(member) is tuple:
        return "floats", _row_width(member), ()
    if get_origin(member) is dict:
        return "json", 0, ()
    return {bool: "bool", int: "int", float: "float", str: "str"}[member], 0, ()


def _limits(field: FieldInfo) -> dict[str, Any]:
    limits: dict[str, Any] = {}
    for rule in field.metadata:
        if isinstance(rule, Ge):
            limits["minimum"] = rule.ge
        elif isinstance(rule, Gt):
            limits |= {"minimum": rule.gt, "above": True}
        elif isinstance(rule, Le):
            limits["maximum"] = rule.le
        elif isinstance(rule, Lt):
            limits |= {"maximum": rule.lt, "below": True}
    return limits


def leaves(model: type[BaseModel], prefix: str = "", *, optional: bool = False) -> Iterator[Leaf]:
    """Yield the parameters of a configuration model, in the order of its fields.

    Parameters
    ----------
    model : type of pydantic model
        What to walk through.
    prefix : str
        Put in front of every name.
    optional : bool
        Whether the whole model may be left out; nothing then has a default.
    """
    for key, field in model.model_fields.items():
        name, members = f"{prefix}{key}", _members(field.annotation)
        default = None if optional or field.is_required() else field.get_default(call_default_factory=True)
        if isinstance(members[0], type) and issubclass(members[0], BaseModel):
            yield from leaves(members[0], f"{name}.", optional=optional or default is None)
            continue
        kind, width, choices = _kind(members)
        text = field.description or name
        if choices:
            text += f"; one of {', '.join(str(choice) for choice in choices)}"
        null = optional or type(None) in get_args(field.annotation)
        yield Leaf(name, kind, null, _flat(default), text, width, choices=choices, **_limits(field))


def _flat(value: Any) -> Any:
    """Return `value` as a parameter: lists of points become one list of numbers, tables JSON text."""
    if isinstance(value, dict):
        return json.dumps({key: entry.model_dump(exclude_defaults=True) for key, entry in value.items()})
    if isinstance(value, (tuple, list)):
        rows = (entry if isinstance(entry, (tuple, list)) else (entry,) for entry in value)
        return [float(number) for row in rows for number in row]
    return value


def _unflat(leaf: Leaf, value: Any) -> Any:
    """Return parameter `value` as what the model expects."""
    if leaf.kind == "json" and isinstance(value, str):
        try:
            return json.loads(value)
        except ValueError:
            raise InputError(
                leaf.name, value, "must be a JSON object", f"It is the {leaf.description}."
            ) from None
    if isinstance(value, (str, bytes, bool)) or value is None:
        return value
    if leaf.kind in ("float", "any") and isinstance(value, int):
        return float(value)
    if leaf.kind not in ("floats", "any") or isinstance(value, (int, float)):
        return value
    numbers = [float(x) if isinstance(x, (int, float)) and not isinstance(x, bool) else x for x in value]
    if leaf.width == 0:
        return numbers
    if len(numbers) % leaf.width:
        raise InputError(
            leaf.name,
            numbers,
            f"must hold {leaf.width} numbers per point",
            "List the coordinates one after another.",
        )
    return [numbers[i : i + leaf.width] for i in range(0, len(numbers), leaf.width)]


def unknown_parameter(name: str, value: Any, known: Iterable[str]) -> InputError:
    """Return the error for a parameter that does not exist, with the names closest to it."""
    names = list(known)
    close = difflib.get_close_matches(name, names) or names
    return InputError(name, value, "is not a known parameter", f"Did you mean: {', '.join(close)}?")


def _nested(model: type[BaseModel], values: Mapping[str, Any]) -> dict[str, Any]:
    """Turn dotted names into nested plain data; an unset parameter of an optional part is left out."""
    known = {leaf.name: leaf for leaf in leaves(model)}
    data: dict[str, Any] = {}
    for name, value in values.items():
        if name not in known:
            raise unknown_parameter(name, value, known)
        if value is None and known[name].default is None:
            continue
        *path, key = name.split(".")
        place = data
        for part in path:
            place = place.setdefault(part, {})
        place[key] = _unflat(known[name], value)
    return data


def model_from_values(model: type[Model], values: Mapping[str, Any]) -> Model:
    """Build a configuration model from parameter values.

    Raises
    ------
    InputError
        Naming the parameter, its value, the limit and the remedy.
    """
    try:
        return model.model_validate_json(json.dumps(_nested(model, values)))
    except ValidationError as error:
        raise input_error(error, model, remedy="See the parameter's description.") from None


def case_from_values(values: Mapping[str, Any]) -> CaseConfig:
    """Build a case from parameter values; another source of the sea, where set, replaces the sea state.

    Raises
    ------
    InputError
        Naming the parameter, its value, the limit and the remedy.
    """
    data = _nested(CaseConfig, values)
    if any(data.get(name) is not None for name in SEA_SOURCES[1:]):
        data["sea_state"] = None
    return parse_case(data)


def case_values(case: CaseConfig) -> dict[str, Any]:
    """Return the parameters of `case`; null ones are left out."""
    found: dict[str, Any] = {}
    for leaf in leaves(CaseConfig):
        value: Any = case
        for part in leaf.name.split("."):
            value = getattr(value, part, None)
        if value is not None:
            found[leaf.name] = _flat(value)
    return found
