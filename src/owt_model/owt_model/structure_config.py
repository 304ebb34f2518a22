"""How a case treats its structure: model, reduction, damping, time integration."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from owt_model.errors import InputError
from owt_model.parts import StaticState
from owt_model.reduction_name import parse_reduction
from owt_model.validation import Frozen

__all__ = ["Damping", "StructureConfig", "damping_ratio", "rayleigh_fit"]

Frequency = Annotated[float, Field(gt=0.0, le=1e4)]
Decrement = Annotated[float, Field(ge=0.0, le=1e4)]
Coefficient = Annotated[float, Field(ge=0.0, le=1e15)]


def damping_ratio(log_decrement: float) -> float:
    """Damping ratio of a logarithmic decrement: delta = 2 pi zeta / sqrt(1 - zeta^2) solved for zeta."""
    return log_decrement / math.hypot(2.0 * math.pi, log_decrement)


def rayleigh_fit(
    frequency_hz: tuple[float, float], log_decrement_percent: tuple[float, float]
) -> tuple[float, float]:
    """Rayleigh coefficients that give two frequencies their logarithmic decrements.

    2 zeta omega = alpha + beta omega^2 at both.

    Parameters
    ----------
    frequency_hz : tuple of float
        Two undamped natural frequencies in Hz.
    log_decrement_percent : tuple of float
        Their logarithmic decrements in percent.

    Returns
    -------
    alpha, beta : float
        In 1/s and s.

    Raises
    ------
    InputError
        If the frequencies are equal, or one coefficient comes out negative: it would drive some mode.
    """
    (first, second), field = frequency_hz, "structure.damping.fit"
    if first == second:
        raise InputError(field, frequency_hz, "needs two different frequencies", "Give two modes in Hz.")
    omega = [2.0 * math.pi * f for f in frequency_hz]
    rate = [2.0 * damping_ratio(d / 100.0) * w for d, w in zip(log_decrement_percent, omega, strict=True)]
    beta = (rate[1] - rate[0]) / (omega[1] ** 2 - omega[0] ** 2)
    alpha = rate[0] - beta * omega[0] ** 2
    # Round-off of a fit whose other coefficient is zero.
    alpha, beta = (0.0 if abs(c) < 1e-12 * max(rate) else c for c in (alpha, beta))
    if alpha < 0.0 or beta < 0.0:
        raise InputError(
            field,
            list(zip(frequency_hz, log_decrement_percent, strict=True)),
            f"makes alpha = {alpha:.3g} 1/s and beta = {beta:.3g} s; neither may be negative",
            "Choose decrements of which the second is about "
            f"{min(first, second) / max(first, second):.3g} to {max(first, second) / min(first, second):.3g} "
            "times the first.",
        )
    return alpha, beta


class Damping(Frozen):
    """Rayleigh damping C = alpha M + beta K, modes that differ from it, and a dashpot at the tower top."""

    alpha: float = Field(0.027, ge=0.0, le=10.0, description="mass proportional coefficient in 1/s")
    beta: float = Field(0.002, ge=0.0, le=1.0, description="stiffness proportional coefficient in s")
    fit: tuple[tuple[Frequency, Decrement], tuple[Frequency, Decrement]] | None = Field(
        None,
        description="two [frequency in Hz, log decrement in percent] that alpha and beta are fitted to, "
        "instead of given",
    )
    modes: tuple[tuple[float, Decrement], ...] | None = Field(
        None, description="[number of a mode, from 1, its log decrement in percent], instead of Rayleigh's"
    )
    tower_top: tuple[Coefficient, Coefficient, Coefficient, Coefficient, Coefficient, Coefficient] | None = (
        Field(
            None,
            description="dashpot from the tower top to the ground: x, y, z in N s/m and about them in "
            "N m s/rad",
        )
    )

    @model_validator(mode="after")
    def _one_rayleigh(self) -> Damping:
        if self.fit is not None:
            for name in ("alpha", "beta"):
                if getattr(self, name) != Damping.model_fields[name].default:
                    raise InputError(
                        f"structure.damping.{name}",
                        getattr(self, name),
                        "is given beside `fit`, which gives alpha and beta",
                        "Leave one of the two out.",
                    )
            _ = self.rayleigh  # what cannot be fitted is refused here
        self._check_modes()
        return self

    def _check_modes(self) -> None:
        numbers = [number for number, _ in self.modes or ()]
        for number in numbers:
            if number < 1 or number != round(number) or numbers.count(number) > 1:
                raise InputError(
                    "structure.damping.modes",
                    number,
                    "must be the number of a mode, 1 for the lowest, each once",
                    "For example [[1, 30], [2, 30]].",
                )

    @property
    def rayleigh(self) -> tuple[float, float]:
        """Alpha in 1/s and beta in s, as given or as fitted."""
        if self.fit is None:
            return self.alpha, self.beta
        (f_1, d_1), (f_2, d_2) = self.fit
        return rayleigh_fit((f_1, f_2), (d_1, d_2))

    def of_lowest(self, count: int) -> Damping:
        """The same, but for ratios of modes beyond the first `count`."""
        known = None if self.modes is None else tuple(mode for mode in self.modes if mode[0] <= count)
        return self.model_copy(update={"modes": known})

    @property
    def mode_ratio(self) -> dict[int, float]:
        """Damping ratio of the modes that are given one, by their index from 0."""
        return {round(number) - 1: damping_ratio(percent / 100.0) for number, percent in self.modes or ()}


class StructureConfig(Frozen):
    """Structure, its reduction and its time integration."""

    model: str = Field(
        "oc4", min_length=1, description="name of a shipped structure, or path of a YAML file or SubDyn deck"
    )
    jacket_stiffness_factor: float | None = Field(
        None, gt=0.0, le=1e3, description="factor on the stiffness of the members, instead of the structure's"
    )
    static_state: StaticState | None = Field(
        None, description="geometric stiffness of the weights, instead of the structure's"
    )
    reduction: str = Field(
        "CB10M10",
        description="full, auto, or CBnn, CBnnMmm, Mmm with orders jk, interface vectors Y, +SIM behind",
    )
    tolerance: float = Field(
        0.001, gt=0.0, lt=1.0, description="estimated error in mean potential energy that auto allows"
    )
    damping: Damping = Field(default_factory=Damping)
    dt_s: float = Field(0.02, gt=0.0, le=60.0, description="integration step in s; divides time.dt_s")
    integrator: Literal["newmark", "newmark-explicit", "generalised-alpha", "exact"] = Field(
        "newmark", description="time integration; exact for loads linear in a step"
    )
    ramp_s: float = Field(
        0.0,
        ge=0.0,
        le=1e6,
        description="time in s over which all loads rise from zero; 0 starts at rest under the first loads",
    )

    @model_validator(mode="after")
    def _known_reduction(self) -> StructureConfig:
        parse_reduction(self.reduction)
        return self
