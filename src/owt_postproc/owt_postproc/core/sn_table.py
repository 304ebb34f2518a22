"""Tables of S-N curves as plain data (what YAML holds), the package's own and those of a user."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from pydantic import Field, ValidationError

from owt_model.errors import InputError
from owt_model.validation import Frozen, input_error
from owt_postproc.core.sn_curve import SNCurve

__all__ = ["parse_sn_tables"]

REMEDY = "See docs/fatigue.md for the format."
Pair = tuple[float, float]


class _Entry(Frozen):
    """What is said of one curve, by itself or by its table."""

    m: float | Pair = Field(description="slope, or both")
    log10_a: float | Pair = Field(description="log10 of the intercept for stress in MPa, or both")
    knee_cycles: float = Field(1e7, description="cycles at which the second slope begins")
    thickness_exponent: float = Field(0.0, ge=0.0, le=1.0, description="exponent k of the thickness effect")
    reference_thickness_m: float = Field(0.025, gt=0.0, le=1.0, description="reference thickness in m")
    environment: str = ""
    edition: str = ""
    source: str = ""
    description: str = ""
    note: str = ""


def parse_sn_tables(data: Any, *, source: str) -> Mapping[str, SNCurve]:
    """Curves by name of a file of tables.

    Parameters
    ----------
    data : object
        Plain data: ``{"tables": [{..., "curves": {name: {...}}}]}``. What a table says holds for those of its
        curves that do not say it themselves; a curve's name is ``NAME_ENVIRONMENT``, or ``NAME`` without one.
    source : str
        What to call the file in errors.

    Raises
    ------
    InputError
        Naming the file, the table, the curve and the field.
    """
    tables = data.get("tables") if isinstance(data, dict) and set(data) == {"tables"} else None
    if not isinstance(tables, list) or not tables:
        raise InputError(source, data, "must hold one key 'tables' with a list of tables", REMEDY)
    curves: dict[str, SNCurve] = {}
    for i, table in enumerate(tables):
        where = f"{source}: tables[{i}]"
        inner = table.get("curves") if isinstance(table, dict) else None
        if not isinstance(inner, dict) or not inner:
            raise InputError(f"{where}.curves", inner, "must hold curves by name", REMEDY)
        shared = {key: value for key, value in table.items() if key != "curves"}
        for name, entry in inner.items():
            curve = _curve(str(name), shared, entry, f"{where}.curves.{name}")
            if curve.name in curves:
                raise InputError(f"{where}.curves.{name}", curve.name, "is there twice", "Rename one.")
            curves[curve.name] = curve
    return MappingProxyType(curves)


def _curve(name: str, shared: dict[str, Any], entry: Any, where: str) -> SNCurve:
    if not isinstance(entry, dict):
        raise InputError(where, entry, "must be a mapping", REMEDY)
    try:
        found = _Entry.model_validate_json(json.dumps({**shared, **entry}))
    except ValidationError as error:
        fault = input_error(error, _Entry, remedy=REMEDY)
        raise InputError(f"{where}.{fault.field}", fault.value, fault.limit, fault.remedy) from None
    except (TypeError, ValueError) as error:
        raise InputError(where, entry, f"is not plain data ({error})", "Quote it.") from None
    return SNCurve(
        name=f"{name}_{found.environment}" if found.environment else name,
        m=_pair(found.m),
        log10_a=_pair(found.log10_a),
        knee_cycles=found.knee_cycles,
        description=found.description,
        edition=found.edition,
        source=found.source,
        note=found.note,
        thickness_exponent=found.thickness_exponent,
        reference_thickness_m=found.reference_thickness_m,
    )


def _pair(value: float | Pair) -> Pair:
    return value if isinstance(value, tuple) else (value, value)
