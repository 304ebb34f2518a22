"""Compiles and caches every numba kernel, so that no first run waits."""

from __future__ import annotations

import os
import time
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
from pkgutil import iter_modules

PACKAGES = ("owt_wave_node", "owt_structure_node", "owt_postproc")

__all__ = ["main"]


def _modules(package: str) -> list[str]:
    """Kernel modules of a package that can be compiled by themselves."""
    root = import_module(f"{package}.kernels")
    inner = [f"{root.__name__}.{found.name}" for found in iter_modules(getattr(root, "__path__", []))]
    return [name for name in inner or [root.__name__] if hasattr(import_module(name), "warm_up")]


def _compile(module: str) -> tuple[str, float]:
    """Call every kernel of a module once with tiny arrays of the production types; return the time in s."""
    start = time.perf_counter()
    import_module(module).warm_up()
    return module, time.perf_counter() - start


def main() -> None:
    """Compile all modules, on as many processors as there are."""
    modules = [module for package in PACKAGES for module in _modules(package)]
    # Long ones first keeps the processors busy to the end.
    modules.sort(key=lambda module: -os.path.getsize(import_module(module).__file__ or os.devnull))
    workers = min(len(modules), len(os.sched_getaffinity(0)))
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for module, elapsed in pool.map(_compile, modules):
            print(f"{module}: {elapsed:.1f} s")


if __name__ == "__main__":
    main()
