"""S-N curves of two slopes, and the Palmgren-Miner sum.

log10 N = log10 a - m log10 S, with S the stress range in MPa: slope m_1 up to the knee, m_2 beyond.
The thickness effect, S (t/t_ref)^k for walls thicker than the reference, is not applied: every wall
counts as no thicker than the reference thickness of the curve's edition.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Any

import numpy as np
import yaml
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["SNCurve", "cycles_to_failure", "miner_damage", "sn_curve", "sn_curves"]

PA_PER_MPA = 1e6


@dataclass(frozen=True)
class SNCurve:
    """An S-N curve of two slopes; `log10_a` and `knee_cycles` for stress in MPa.

    A curve of one slope has the same slope and intercept twice.
    """

    name: str
    m: tuple[float, float]
    log10_a: tuple[float, float]
    knee_cycles: float
    description: str = ""
    edition: str = ""
    source: str = ""
    thickness_exponent: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a curve that cannot be.

        Raises
        ------
        InputError
            Naming the field.
        """
        for field, values in (("m", self.m), ("log10_a", self.log10_a), ("knee_cycles", (self.knee_cycles,))):
            if not all(np.isfinite(value) and value > 0.0 for value in values):
                raise InputError(
                    f"{self.name}.{field}", values, "must be finite and > 0", "Check the S-N table."
                )

    @property
    def knee_stress_pa(self) -> float:
        """Stress range in Pa at the knee, on the first slope."""
        return float((10.0 ** self.log10_a[0] / self.knee_cycles) ** (1.0 / self.m[0]) * PA_PER_MPA)

    @property
    def coefficients(self) -> Float[np.ndarray, " coefficient"]:
        """Knee stress in Pa; 1/a and m above it; 1/a and m below it, for stress in Pa."""
        inverse = [10.0**-a / PA_PER_MPA**m for a, m in zip(self.log10_a, self.m, strict=True)]
        return np.array([self.knee_stress_pa, inverse[0], self.m[0], inverse[1], self.m[1]])


@cache
def sn_curves() -> Mapping[str, SNCurve]:
    """The curves of the package's table by name."""
    text = (resources.files("owt_postproc") / "data" / "sn_curves.yaml").read_text(encoding="utf-8")
    table: dict[str, Any] = yaml.safe_load(text)
    return MappingProxyType(
        {
            name: SNCurve(
                name=name,
                m=(float(entry["m"][0]), float(entry["m"][1])),
                log10_a=(float(entry["log10_a"][0]), float(entry["log10_a"][1])),
                knee_cycles=float(entry["knee_cycles"]),
                description=entry["description"],
                edition=table["edition"],
                source=table["source"],
                thickness_exponent=float(entry["thickness_exponent"]),
            )
            for name, entry in table["curves"].items()
        }
    )


def sn_curve(name: str) -> SNCurve:
    """The curve called `name`.

    Raises
    ------
    InputError
        If there is none; the message lists the known ones.
    """
    curves = sn_curves()
    if name not in curves:
        raise InputError(
            "fatigue.sn_curve", name, "is not a known S-N curve", f"Known are: {', '.join(sorted(curves))}."
        )
    return curves[name]


def cycles_to_failure(
    curve: SNCurve, stress_range: Float[np.ndarray, "*shape"]
) -> Float[np.ndarray, "*shape"]:
    """Cycles N to failure at a stress range in Pa; infinite at a range of zero.

    Raises
    ------
    InputError
        If a range is negative or not finite.
    """
    if not (np.isfinite(stress_range) & (stress_range >= 0.0)).all():
        raise InputError("stress_range", stress_range, "must be finite and >= 0 Pa", "Give ranges.")
    knee, inverse_1, m_1, inverse_2, m_2 = curve.coefficients
    with np.errstate(divide="ignore"):
        upper, lower = 1.0 / (inverse_1 * stress_range**m_1), 1.0 / (inverse_2 * stress_range**m_2)
    return np.asarray(np.where(stress_range >= knee, upper, lower))


def miner_damage(
    curve: SNCurve, stress_range: Float[np.ndarray, " cycle"], count: Float[np.ndarray, " cycle"]
) -> float:
    """Palmgren-Miner sum of `count` cycles of `stress_range` in Pa."""
    return float(np.sum(count / cycles_to_failure(curve, stress_range)))
