"""Element axes: the one convention that loads, stiffness and stress recovery share.

Local x runs from the first to the second node of the element, local y is horizontal, local z completes
the right-handed triad and never points down (thesis figure 4.2). A vertical element has no horizontal
projection: alpha = 0 there, so that local y is global y, and local z is global -x for an element that
runs upwards, +x for one that runs downwards.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from owt_model.errors import InputError

__all__ = ["VERTICAL", "rotation"]

#: Horizontal projection over length below which an element counts as vertical.
VERTICAL = 1e-9


def rotation(
    start: Float[np.ndarray, "*batch 3"], end: Float[np.ndarray, "*batch 3"]
) -> Float[np.ndarray, "*batch 3 3"]:
    """Return the matrix T that takes global components to element components [eq. 4.60].

    The rows of T are the unit vectors of the element axes: ``local = T @ global``. With
    alpha = atan2(L_y, L_x) and beta = atan2(L_z, L_p), L_p the horizontal projection (4.61 and 4.62, the
    sign of beta corrected)::

        T = [ cos a cos b    sin a cos b   sin b ]
            [   -sin a          cos a        0   ]
            [-cos a sin b   -sin a sin b   cos b ]

    Parameters
    ----------
    start, end : float arrays [..., 3]
        Positions of the first and the second node in m.

    Raises
    ------
    InputError
        If an element has no length.
    """
    along = end - start
    length = np.linalg.norm(along, axis=-1)
    if not (np.isfinite(length) & (length > 0.0)).all():
        raise InputError("element", "start = end", "must have a finite length > 0 m", "Check the joints.")
    projection = np.hypot(along[..., 0], along[..., 1])
    vertical = projection <= VERTICAL * length
    safe = np.where(vertical, 1.0, projection)
    cos_a = np.where(vertical, 1.0, along[..., 0] / safe)
    sin_a = np.where(vertical, 0.0, along[..., 1] / safe)
    cos_b = np.where(vertical, 0.0, projection / length)
    sin_b = np.where(vertical, np.sign(along[..., 2]), along[..., 2] / length)
    zero = np.zeros_like(length)
    rows = [
        [cos_a * cos_b, sin_a * cos_b, sin_b],
        [-sin_a, cos_a, zero],
        [-cos_a * sin_b, -sin_a * sin_b, cos_b],
    ]
    return np.ascontiguousarray(np.moveaxis(np.array(rows), (0, 1), (-2, -1)))
