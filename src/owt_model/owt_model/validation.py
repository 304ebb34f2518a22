"""Turns a pydantic validation error into the project's one-line InputError."""

from __future__ import annotations

from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from owt_model.errors import InputError

__all__ = ["input_error"]

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


def _location(parts: tuple[int | str, ...]) -> str:
    text = ""
    for part in parts:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else str(part))
    return text


def _known_keys(model: type[BaseModel], parts: tuple[int | str, ...]) -> list[str]:
    """Field names of the (nested) model in which an unknown key was found."""
    for part in parts:
        field = model.model_fields.get(str(part))
        if field is None:
            continue
        for candidate in (field.annotation, *get_args(field.annotation)):
            if isinstance(candidate, type) and issubclass(candidate, BaseModel):
                model = candidate
    return list(model.model_fields)


def _description(model: type[BaseModel], parts: tuple[int | str, ...]) -> str:
    description = ""
    for part in parts:
        field = model.model_fields.get(str(part)) if isinstance(part, str) else None
        if field is None:
            continue
        description = field.description or description
        for candidate in (field.annotation, *get_args(field.annotation)):
            if isinstance(candidate, type) and issubclass(candidate, BaseModel):
                model = candidate
    return description


def input_error(error: ValidationError, model: type[BaseModel], *, remedy: str) -> InputError:
    """Return the first fault of `error` as an InputError with field, value, limit and remedy."""
    first: Any = error.errors(include_url=False)[0]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause
    kind, parts, value = first["type"], tuple(first["loc"]), first["input"]
    limit = _RULES.get(kind, first["msg"].replace("Input should", "must").replace("'", ""))
    if kind == "extra_forbidden":
        remedy = f"Known keys here: {', '.join(_known_keys(model, parts[:-1]))}."
    elif description := _description(model, parts):
        remedy = f"It is the {description}. {remedy}"
    return InputError(_location(parts) or "case", "nothing" if kind == "missing" else value, limit, remedy)
