"""Compiles and caches every numba kernel, so that no first run waits."""

from __future__ import annotations

import time
from importlib import import_module

PACKAGES = ("owt_wave_node", "owt_structure_node", "owt_postproc")

__all__ = ["main"]


def main() -> None:
    """Call every kernel once with tiny arrays of the production types."""
    for package in PACKAGES:
        start = time.perf_counter()
        import_module(f"{package}.kernels").warm_up()
        print(f"kernels of {package}: {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main()
