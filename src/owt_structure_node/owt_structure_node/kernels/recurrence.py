"""One-step recurrences of oscillators, many at once: uncoupled, or coupled by a few dashpots."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["advance", "warm_up"]


@njit(cache=True, nogil=True, fastmath={"contract"})
def advance(
    transition, old, new, substeps, load, by_mode, by_direction, inverse, force,
    displacement, velocity, acceleration,
):  # fmt: skip
    """Apply s_1 = transition s_0 + old f_0 + new f_1, s = (x, v, a), the load linear between its samples.

    `transition` is [3, 3, mode], `old` and `new` [3, mode], `load` [sample, mode]; the output arrays are
    [1 + substeps (samples - 1), mode] and hold the state at the first load sample in row 0.

    The dashpot forces -G y, y = G' v, are part of the load. From v_1 = v_free - new_v G y_1 follows
    (I + G' new_v G) y_1 = G' v_free; `inverse` [direction, direction] is that of the matrix. `by_mode`
    [mode, direction] is G, `by_direction` its transpose, without columns or rows where there are no dashpots;
    `force` [mode] is G y of row 0, and of the last row when the kernel returns.
    """
    samples, modes = load.shape
    directions = by_mode.shape[1]
    rate = np.empty(directions)
    row = 0
    for i in range(1, samples):
        for k in range(substeps):
            before, after = k / substeps, (k + 1) / substeps
            x, v, a = displacement[row], velocity[row], acceleration[row]
            x_1, v_1, a_1 = displacement[row + 1], velocity[row + 1], acceleration[row + 1]
            for j in range(modes):
                rise = load[i, j] - load[i - 1, j]
                f_0, f_1 = load[i - 1, j] + before * rise - force[j], load[i - 1, j] + after * rise
                x_1[j] = (
                    transition[0, 0, j] * x[j]
                    + transition[0, 1, j] * v[j]
                    + transition[0, 2, j] * a[j]
                    + old[0, j] * f_0
                    + new[0, j] * f_1
                )
                v_1[j] = (
                    transition[1, 0, j] * x[j]
                    + transition[1, 1, j] * v[j]
                    + transition[1, 2, j] * a[j]
                    + old[1, j] * f_0
                    + new[1, j] * f_1
                )
                a_1[j] = (
                    transition[2, 0, j] * x[j]
                    + transition[2, 1, j] * v[j]
                    + transition[2, 2, j] * a[j]
                    + old[2, j] * f_0
                    + new[2, j] * f_1
                )
            row += 1
            if directions == 0:
                continue
            rate[:] = 0.0
            for j in range(modes):
                for r in range(directions):
                    rate[r] += by_mode[j, r] * v_1[j]
            force[:] = 0.0
            for r in range(directions):
                y = 0.0
                for q in range(directions):
                    y += inverse[r, q] * rate[q]
                for j in range(modes):
                    force[j] += by_direction[r, j] * y
            for j in range(modes):
                x_1[j] -= new[0, j] * force[j]
                v_1[j] -= new[1, j] * force[j]
                a_1[j] -= new[2, j] * force[j]


def warm_up() -> None:
    """Compile for the array types that the package uses."""
    load, out = np.zeros((2, 2)), [np.zeros((2, 2)) for _ in range(3)]
    rule = (np.ones((3, 3, 2)), np.ones((3, 2)), np.ones((3, 2)), 1, load)
    advance(*rule, np.ones((2, 1)), np.ones((1, 2)), np.ones((1, 1)), np.zeros(2), out[0], out[1], out[2])
