"""Compiled kernels: arrays and scalars only."""

from __future__ import annotations

__all__ = ["warm_up"]


def warm_up() -> None:
    """Compile and cache every kernel for the array types that the package uses."""
    from owt_postproc.kernels import fatigue, rainflow, turning

    turning.warm_up()
    rainflow.warm_up()
    fatigue.warm_up()
