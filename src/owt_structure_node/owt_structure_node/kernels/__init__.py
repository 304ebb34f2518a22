"""Compiled kernels: arrays and scalars only."""

from __future__ import annotations

__all__ = ["warm_up"]


def warm_up() -> None:
    """Compile and cache every kernel for the array types that the package uses."""
    from owt_structure_node.kernels import energy, recurrence, stress

    energy.warm_up()
    recurrence.warm_up()
    stress.warm_up()
