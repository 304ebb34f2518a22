"""What a structure is coloured by, and what is said about each member end and joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from owt_postproc.report_usage import Usage

__all__ = ["DesignLife", "Measure", "design_life", "end_texts", "measures", "power"]

YEAR_S = 365.25 * 86400.0
#: Decades of a logarithmic colour scale.
DECADES = 6.0


@dataclass(frozen=True)
class DesignLife:
    """What damage is compared with: a sum of one after the design life, with the design fatigue factor."""

    years: float
    factor: float

    def utilisation(self, damage: Float[np.ndarray, " n"], duration_s: float) -> Float[np.ndarray, " n"]:
        """Damage x factor over the allowed sum of one, if the record went on for the whole design life."""
        return np.asarray(damage * (self.factor * self.years * YEAR_S / max(duration_s, 1e-300)))


def design_life(case: Mapping[str, Any]) -> DesignLife | None:
    """Design life that a case names; None where it names none."""
    fatigue = case.get("fatigue") or {}
    years, factor = fatigue.get("design_life_years"), fatigue.get("design_fatigue_factor")
    return None if years is None or factor is None else DesignLife(float(years), float(factor))


@dataclass(frozen=True)
class Measure:
    """A number per member end, and how it is shown.

    Attributes
    ----------
    key, label : str
        Of the selector.
    unit : str
        Empty for a pure number.
    value : float array [end]
    logarithmic : bool
        Colours over six decades below the largest; else from zero.
    note : str
        What a reader must know.
    """

    key: str
    label: str
    unit: str
    value: Float[np.ndarray, " end"]
    logarithmic: bool
    note: str

    def scaled(self) -> tuple[Float[np.ndarray, " end"], float, float]:
        """What the colours follow, from low to high: the value, or its logarithm."""
        top = float(self.value.max()) or 1.0
        if not self.logarithmic:
            return self.value, 0.0, top
        high = float(np.log10(top))
        return np.log10(np.maximum(self.value, top * 10.0**-DECADES)), high - DECADES, high

    def plain(self) -> dict[str, Any]:
        """For the page's script: colours as shares of the scale, and its ticks."""
        scaled, low, high = self.scaled()
        if self.logarithmic:
            ticks = [float(v) for v in np.arange(np.ceil(low), high + 1e-9)]
            text = [f"10<sup>{round(v)}</sup>" for v in ticks]
        else:
            step = _round_step(high / 5.0)
            ticks = [float(v) for v in np.arange(0.0, high + 1e-9 * high, step)]
            text = [f"{v:g}" for v in ticks]
        return {
            "key": self.key,
            "title": self.label + (f"<br>in {self.unit}" if self.unit else ""),
            "note": self.note,
            "share": [round(float(v), 4) for v in (scaled - low) / (high - low)],
            "tick": [(v - low) / (high - low) for v in ticks],
            "text": text,
        }


def _round_step(step: float) -> float:
    """1, 2 or 5 times a power of ten, near `step`."""
    base = 10.0 ** np.floor(np.log10(step))
    return float(base * min((1.0, 2.0, 5.0, 10.0), key=lambda m: abs(m - step / base)))


def measures(usage: Usage, design: DesignLife | None) -> list[Measure]:
    """The quantities that a structure can be coloured by; the first is shown first."""
    found = [
        Measure(
            "damage", "damage", "", usage.end_damage, True,
            "Palmgren-Miner sum over the record, largest of the spots of each end. Logarithmic; six "
            "decades and "
            "more below the largest is the lightest colour.",
        ),
        Measure(
            "range", "largest stress range", "MPa", 1e-6 * usage.end_max_range, False,
            "Largest rainflow range of the normal stress, concentration factor included, largest of "
            "the spots "
            "of each end.",
        ),
        Measure(
            "total", "total stress", "MPa", 1e-6 * usage.total_stress, False,
            "Sum of range × count of the unsigned nominal von Mises stress: the measure of the "
            "thesis, no damage.",
        ),
    ]  # fmt: skip
    if design is not None:
        found.append(
            Measure(
                "utilisation", "utilisation", "",
                design.utilisation(usage.end_damage, usage.duration_s), True,
                f"Damage × {design.years:g} years / record × design fatigue factor {design.factor:g}, "
                "over the "
                "allowed sum of 1, as if what was counted went on for the whole design life. "
                "Logarithmic, six "
                "decades.",
            )
        )  # fmt: skip
    return found


def end_texts(usage: Usage, design: DesignLife | None) -> list[str]:
    """Name and numbers of each member end, and of the worst spot on it."""
    spot, damage, largest = usage.worst_spot, usage.end_damage, usage.end_max_range
    used = None if design is None else design.utilisation(damage, usage.duration_s)
    texts = []
    for e, name in enumerate(usage.end_name):
        member, _, joint = name.partition(":")
        lines = [
            f"<b>member {member}, end at joint {joint}</b>",
            f"damage {power(float(damage[e]))}",
            *([] if used is None else [f"utilisation {used[e]:.3g}"]),
            f"largest range {1e-6 * largest[e]:.1f} MPa",
            f"total stress {1e-6 * usage.total_stress[e]:.1f} MPa",
            f"worst spot: {usage.describe(int(spot[e]))}",
        ]
        texts.append("<br>".join(lines))
    return texts


def power(value: float) -> str:
    """Three digits and a power of ten."""
    digits, exponent = f"{value:.2e}".split("e")
    return f"{digits}×10{str(int(exponent)).translate(_SUPERSCRIPT)}" if value else "0"


_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
