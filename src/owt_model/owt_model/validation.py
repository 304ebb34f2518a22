"""The base of all validated data, and its errors as the project's one-line InputError."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

from owt_model.errors import InputError

__all__ = ["Frozen", "input_error"]

_ALTERNATIVE = re.compile(r"^(constrained-\w+|float|tuple\[.*\])$")
_RULES = {
    "extra_forbidden": "is not a known key",
    "missing": "is missing",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be a text",
    "none_required": "must be null",
    "model_type": "must be an object",
    "model_attributes_type": "must be an object",
    "tuple_type": "must be a list",
}


class Frozen(BaseModel):
    """Data that never changes: no unknown key, no conversion of types, finite numbers only."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def _named(parts: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Location without pydantic's names of the alternatives of a type, which no user wrote."""
    return tuple(part for part in parts if not (isinstance(part, str) and _ALTERNATIVE.search(part)))


def _most_telling(errors: list[Any]) -> Any:
    """The first error; of the alternatives of one field, the one that got furthest into the value."""
    first = errors[0]
    place = tuple(first["loc"])
    if _named(place) == place:
        return first
    shared = next(i for i, part in enumerate(place) if not _named((part,)))
    same = [error for error in errors if tuple(error["loc"])[:shared] == place[:shared]]
    wrong_type = ("float_type", "int_type", "tuple_type", "string_type")
    return max(same, key=lambda error: (error["type"] not in wrong_type, len(error["loc"])))


def _location(parts: tuple[int | str, ...]) -> str:
    text = ""
    for part in parts:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else str(part))
    return text


def _walk(
    model: type[BaseModel], parts: tuple[int | str, ...]
) -> Iterator[tuple[FieldInfo, type[BaseModel]]]:
    """Fields on the way to a location, each with the model whose keys come next."""
    for part in parts:
        field = model.model_fields.get(str(part))
        if field is None:
            continue
        for candidate in (field.annotation, *get_args(field.annotation)):
            if isinstance(candidate, type) and issubclass(candidate, BaseModel):
                model = candidate
        yield field, model


def _known_keys(model: type[BaseModel], parts: tuple[int | str, ...]) -> list[str]:
    """Field names of the (nested) model in which an unknown key was found."""
    inner = [model, *(entered for _, entered in _walk(model, parts))][-1]
    return list(inner.model_fields)


def _description(model: type[BaseModel], parts: tuple[int | str, ...]) -> str:
    """Description of the innermost field on the way to a location that has one."""
    found = [field.description for field, _ in _walk(model, parts) if field.description]
    return found[-1] if found else ""


def input_error(error: ValidationError, model: type[BaseModel], *, remedy: str) -> InputError:
    """Return the first fault of `error` as an InputError with field, value, limit and remedy."""
    first: Any = _most_telling(error.errors(include_url=False))
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause
    kind, value = first["type"], first["input"]
    parts = _named(tuple(first["loc"]))
    limit = _RULES.get(kind, first["msg"].replace("Input should", "must").replace("'", ""))
    if kind == "extra_forbidden":
        remedy = f"Known keys here: {', '.join(_known_keys(model, parts[:-1]))}."
    elif description := _description(model, parts):
        remedy = f"It is the {description}. {remedy}"
    return InputError(_location(parts) or "case", "nothing" if kind == "missing" else value, limit, remedy)
