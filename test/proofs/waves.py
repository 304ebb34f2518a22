"""Wave fields: second order, potential flow, free surface, headings, reference seas."""

from __future__ import annotations

import numpy as np

from owt_wave_node.core.dispersion import wavenumber
from proofs.registry import Proof

G = 9.81


def dispersion(solve) -> float:
    """Largest relative residual of g k tanh kd = omega^2, 1e-3 to 60 rad/s, four depths."""
    omega = np.geomspace(1e-3, 60.0, 400)
    return max(
        float(np.abs(G * k * np.tanh(k * d) / omega**2 - 1.0).max())
        for d in (0.5, 20.0, 50.0, 4000.0)
        for k in [solve(omega, d)]
    )


PROOFS = (
    Proof(
        key="dispersion",
        claim="wave numbers solve the dispersion relation",
        against="its residual, 4 depths, 1e-3 to 60 rad/s",
        error=dispersion,
        right=lambda omega, d: wavenumber(omega, water_depth=d, gravity=G),
        wrong={"deep water": lambda omega, d: omega**2 / G},
        allowed=5e-15,
        reason="a few units in the last place of tanh",
    ),
)
