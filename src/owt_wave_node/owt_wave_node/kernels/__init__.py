"""Compiled kernels: arrays and scalars only."""

from __future__ import annotations

__all__ = ["warm_up"]


def warm_up() -> None:
    """Compile and cache every kernel for the array types that the package uses."""
    from owt_wave_node.kernels import (
        compressed,
        directional,
        fft,
        morison,
        spectra,
        surface,
        transfer,
        wheeler,
    )

    for module in (fft, transfer, spectra, morison, surface, wheeler, directional, compressed):
        module.warm_up()
