"""An S-N curve of two slopes with its thickness effect.

log10 N = log10 a - m log10 (S (t/t_ref)^k), with S the stress range in MPa and t the wall's thickness, not
less than t_ref: slope m_1 up to the knee, m_2 beyond.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["SNCurve"]

PA_PER_MPA = 1e6
#: How far apart log10 N of both slopes may be at the knee; printed constants have three decimals.
KNEE_GAP = 0.01


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
    note: str = ""
    thickness_exponent: float = 0.0
    reference_thickness_m: float = 0.025

    def __post_init__(self) -> None:
        """Refuse a curve that cannot be.

        Raises
        ------
        InputError
            Naming the field.
        """
        remedy = "Check the S-N table."
        for field, values in (
            ("m", self.m),
            ("log10_a", self.log10_a),
            ("knee_cycles", (self.knee_cycles,)),
            ("reference_thickness_m", (self.reference_thickness_m,)),
        ):
            if not all(np.isfinite(value) and value > 0.0 for value in values):
                raise InputError(f"{self.name}.{field}", values, "must be finite and > 0", remedy)
        if not (np.isfinite(self.thickness_exponent) and self.thickness_exponent >= 0.0):
            raise InputError(
                f"{self.name}.thickness_exponent", self.thickness_exponent, "must be finite and >= 0", remedy
            )
        beyond = self.log10_a[1] - self.m[1] * np.log10(self.knee_stress_pa / PA_PER_MPA)
        if abs(beyond - np.log10(self.knee_cycles)) > KNEE_GAP and not self.has_one_slope:
            raise InputError(
                f"{self.name}.log10_a",
                self.log10_a,
                f"leaves a gap at the knee: {self.knee_cycles:g} cycles before, {10**beyond:.4g} after it",
                remedy,
            )

    @property
    def has_one_slope(self) -> bool:
        """Whether slope and intercept are the same on both sides of the knee."""
        return self.m[0] == self.m[1] and self.log10_a[0] == self.log10_a[1]

    @property
    def knee_stress_pa(self) -> float:
        """Stress range in Pa at the knee, on the first slope."""
        return float((10.0 ** self.log10_a[0] / self.knee_cycles) ** (1.0 / self.m[0]) * PA_PER_MPA)

    @property
    def coefficients(self) -> Float[np.ndarray, " coefficient"]:
        """Knee stress in Pa; 1/a and m above it; 1/a and m below it, for stress in Pa."""
        return self.coefficients_for(self.reference_thickness_m)

    def thickness_factor(self, thickness_m: float) -> float:
        """Factor (t/t_ref)^k on the stress range, 1 for walls thinner than the reference.

        Raises
        ------
        InputError
            If the thickness is not finite and > 0 m.
        """
        if not (np.isfinite(thickness_m) and thickness_m > 0.0):
            raise InputError("thickness_m", thickness_m, "must be finite and > 0 m", "Check the wall.")
        return float(max(1.0, thickness_m / self.reference_thickness_m) ** self.thickness_exponent)

    def coefficients_for(self, thickness_m: float) -> Float[np.ndarray, " coefficient"]:
        """Coefficients for the stress range in a wall of `thickness_m`, its thickness effect included.

        Returns
        -------
        float array [5]
            Knee stress in Pa; 1/a and m above it; 1/a and m below it, for stress in Pa.

        Raises
        ------
        InputError
            If the thickness is not finite and > 0 m.
        """
        factor = self.thickness_factor(thickness_m)
        inverse = [10.0**-a * (factor / PA_PER_MPA) ** m for a, m in zip(self.log10_a, self.m, strict=True)]
        return np.array([self.knee_stress_pa / factor, inverse[0], self.m[0], inverse[1], self.m[1]])
