"""What a proof is: a claim about the code, and the wrong variants that the same measure must refuse."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

__all__ = ["Found", "Proof", "found"]


@dataclass(frozen=True, eq=False)
class Proof:
    """A claim, how far the code is from it, and how far wrong variants are.

    A variant is whatever `error` takes: a function, a flag, a number. The right one is the code as it is.
    Each wrong one is a mistake that somebody could make, seen through the same measure: if it passed, the
    proof would prove nothing.

    Attributes
    ----------
    key : str
        Unique name in words joined by hyphens, e.g. "stokes-second-order".
    claim, against : str
        What is claimed and what it is compared with, one line each, for the table of docs/verification.md.
    error : callable
        Error of a variant, >= 0, in the unit of `allowed`.
    right : Any
        The variant that must lie within `allowed`.
    wrong : mapping of str to Any
        Name of each wrong variant and the variant; each must lie above `allowed`.
    allowed : float
        Largest error that is accepted.
    reason : str
        Where that tolerance comes from.
    """

    key: str
    claim: str
    against: str
    error: Callable[[Any], float]
    right: Any
    wrong: Mapping[str, Any]
    allowed: float
    reason: str


@dataclass(frozen=True)
class Found:
    """Errors found of a proof: of its right variant, and of each wrong one by name."""

    right: float
    wrong: Mapping[str, float]

    def failures(self, allowed: float) -> list[str]:
        """What contradicts the proof; a value that is no number always does."""
        failed = [] if self.right <= allowed else [f"right variant: {self.right:.3g} above {allowed:g}"]
        return failed + [
            f"wrong variant {name!r} passes: {value:.3g} within {allowed:g}"
            for name, value in self.wrong.items()
            if not (value > allowed and math.isfinite(value))
        ]


@cache
def found(proof: Proof) -> Found:
    """Evaluate the right variant of `proof` and every wrong one, once."""
    return Found(
        float(proof.error(proof.right)),
        {name: float(proof.error(variant)) for name, variant in proof.wrong.items()},
    )
