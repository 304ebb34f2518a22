"""Linear dispersion in water of finite depth [eq. 2.8]."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.errors import ComputationError

__all__ = ["wavenumber"]

#: Largest relative residual of the dispersion relation that counts as solved.
TOLERANCE = 1e-14


def wavenumber(
    omega: Float[np.ndarray, "*shape"], *, water_depth: float, gravity: float
) -> Float[np.ndarray, "*shape"]:
    """Return the wave number k in rad/m that solves omega^2 = g k tanh(k d) [eq. 2.8].

    Newton's method on x tanh x = y, x = k d, y = omega^2 d / g, from Eckart's estimate y / sqrt(tanh y).

    Parameters
    ----------
    omega : float array
        Angular frequencies in rad/s, > 0.
    water_depth, gravity : float
        Depth d in m and gravity g in m/s2.

    Raises
    ------
    ComputationError
        If the residual does not fall to round-off.
    """
    y = omega**2 * (water_depth / gravity)
    x = y / np.sqrt(np.tanh(y))
    for _ in range(8):
        tanh = np.tanh(x)
        x = x - (x * tanh - y) / (tanh + x * (1.0 - tanh**2))
    residual = np.abs(x * np.tanh(x) - y) / y
    if not (residual <= TOLERANCE).all():
        raise ComputationError(
            f"dispersion relation not solved: relative residual {np.nanmax(residual):.1e} above {TOLERANCE:g}"
        )
    return np.asarray(x / water_depth)
