"""Command-line flags derived from the configuration: types and help are those of its fields."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from owt_model.config import CaseConfig, SeaStateConfig, Stream, StructureConfig, Wave, load_case, parse_case
from owt_model.errors import InputError

__all__ = ["add_case_flags", "case_from_flags"]

#: Flag -> section of the case and its field.
FLAGS: dict[str, tuple[str, str, type[BaseModel]]] = {
    "hs": ("sea_state", "hs_m", SeaStateConfig),
    "tp": ("sea_state", "tp_s", SeaStateConfig),
    "gamma": ("sea_state", "gamma", SeaStateConfig),
    "direction": ("sea_state", "direction_deg", SeaStateConfig),
    "seed": ("sea_state", "seed", SeaStateConfig),
    "order": ("wave", "order", Wave),
    "stretching": ("wave", "stretching", Wave),
    "reduction": ("structure", "reduction", StructureConfig),
    "tolerance": ("structure", "tolerance", StructureConfig),
    "model": ("structure", "model", StructureConfig),
    "rate": ("stream", "rate", Stream),
}


#: Where the field's own description does not suit the command line.
HELP = {"gamma": "JONSWAP peak enhancement"}


def _parser_of(annotation: Any) -> type:
    """Type that a flag's text is read as."""
    if get_origin(annotation) is Literal:
        return type(get_args(annotation)[0])
    kinds = [kind for kind in (get_args(annotation) or (annotation,)) if kind is not type(None)]
    return kinds[0] if kinds[0] in (int, float, str) else str


def add_case_flags(parser: argparse.ArgumentParser, *, without: Collection[str] = ()) -> None:
    """Declare ``--case``, ``--duration`` and one flag per entry of FLAGS, but for those in `without`."""
    default = CaseConfig()
    parser.add_argument(
        "--case", type=Path, metavar="CASE.json", help="case file; flags change what it says"
    )  # fmt: skip
    parser.add_argument(
        "--duration", type=float, default=None, metavar="S",
        help=f"simulated time in s (default {default.time.duration_s:g}, or that of the case file)",
    )  # fmt: skip
    for flag, (_, name, model) in FLAGS.items():
        if flag in without:
            parser.set_defaults(**{flag: None})
            continue
        field = model.model_fields[name]
        shown = "by eq. 4.80" if field.default is None else field.default
        parser.add_argument(
            f"--{flag}", type=_parser_of(field.annotation), default=None,
            help=f"{HELP.get(flag, field.description)} (default {shown})".replace("%", "%%"),
        )  # fmt: skip


def case_from_flags(options: argparse.Namespace) -> CaseConfig:
    """Build the case that the flags describe.

    Raises
    ------
    InputError
        As any case file; if the duration is not a whole number of time steps; if a flag of the sea state is
        given for a case file whose sea is given otherwise.
    """
    changes: dict[str, dict[str, Any]] = {}
    for flag, (section, name, _) in FLAGS.items():
        value = getattr(options, flag)
        if value is not None:
            changes.setdefault(section, {})[name] = value
    base: dict[str, Any] = {}
    if options.case is not None:
        base = load_case(options.case).model_dump(mode="json", exclude_unset=True)
    dt = parse_case({"time": base.get("time", {})}).time.dt_s
    if options.duration is not None:
        steps = options.duration / dt
        if not 2.0 <= steps <= 1e7 or abs(steps - round(steps)) > 1e-6:
            raise InputError(
                "duration", options.duration,
                f"must be a whole number of time steps of {dt:g} s, two at least", "For example 600.",
            )  # fmt: skip
        changes.setdefault("time", {})["n"] = round(steps)
    for section, values in changes.items():
        base[section] = {**(base.get(section) or {}), **values}
    return parse_case(base)
