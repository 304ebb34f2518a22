"""S-N curves by name, and the Palmgren-Miner sum."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
import yaml
from jaxtyping import Float

from owt_model.errors import InputError
from owt_postproc.core.sn_curve import SNCurve
from owt_postproc.core.sn_table import parse_sn_tables

__all__ = ["SNCurve", "cycles_to_failure", "miner_damage", "sn_curve", "sn_curves"]


@cache
def _shipped() -> Mapping[str, SNCurve]:
    text = (resources.files("owt_postproc") / "data" / "sn_curves.yaml").read_text(encoding="utf-8")
    return parse_sn_tables(yaml.safe_load(text), source="sn_curves.yaml")


def sn_curves(file: str | None = None) -> Mapping[str, SNCurve]:
    """Curves by name: those of the package's table, and those of a YAML file of the same format.

    Raises
    ------
    InputError
        If the file cannot be read, is not of the format, or has a curve of a name that the package uses.
    """
    if file is None:
        return _shipped()
    try:
        data = yaml.safe_load(Path(file).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            "fatigue.sn_file", file, f"cannot be read as YAML ({reason})", "Give the path of an S-N table."
        ) from None
    own = parse_sn_tables(data, source=file)
    taken = sorted(set(own) & set(_shipped()))
    if taken:
        raise InputError(
            "fatigue.sn_file", file, f"has a curve called {taken[0]}, as the package has", "Rename it."
        )
    return {**_shipped(), **own}


def sn_curve(name: str, file: str | None = None) -> SNCurve:
    """The curve called `name` of the package's table, or of a user's `file`.

    Raises
    ------
    InputError
        If there is none, the message lists the known ones; or as :func:`sn_curves`.
    """
    curves = sn_curves(file)
    if name not in curves:
        raise InputError(
            "fatigue.sn_curve", name, "is not a known S-N curve", f"Known are: {', '.join(sorted(curves))}."
        )
    return curves[name]


def cycles_to_failure(
    curve: SNCurve, stress_range: Float[np.ndarray, "*shape"], *, thickness_m: float | None = None
) -> Float[np.ndarray, "*shape"]:
    """Cycles N to failure at a stress range in Pa; infinite at a range of zero.

    Without `thickness_m` the wall is not thicker than the curve's reference.

    Raises
    ------
    InputError
        If a range is negative or not finite, or the thickness not > 0.
    """
    if not (np.isfinite(stress_range) & (stress_range >= 0.0)).all():
        raise InputError("stress_range", stress_range, "must be finite and >= 0 Pa", "Give ranges.")
    knee, inverse_1, m_1, inverse_2, m_2 = (
        curve.coefficients if thickness_m is None else curve.coefficients_for(thickness_m)
    )
    with np.errstate(divide="ignore"):
        upper, lower = 1.0 / (inverse_1 * stress_range**m_1), 1.0 / (inverse_2 * stress_range**m_2)
    return np.asarray(np.where(stress_range >= knee, upper, lower))


def miner_damage(
    curve: SNCurve,
    stress_range: Float[np.ndarray, " cycle"],
    count: Float[np.ndarray, " cycle"],
    *,
    thickness_m: float | None = None,
) -> float:
    """Palmgren-Miner sum of `count` cycles of `stress_range` in Pa."""
    return float(np.sum(count / cycles_to_failure(curve, stress_range, thickness_m=thickness_m)))
