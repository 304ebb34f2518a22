"""What makes a short command start sooner; see docs/performance.md for the gain."""

from __future__ import annotations

import gc
import sys
from importlib import import_module
from importlib.util import LazyLoader, find_spec, module_from_spec

__all__ = ["start_quickly"]

#: Objects made before the garbage collector looks for cycles; the default of 700 costs 0.1 s during imports.
COLLECT_AFTER = 100_000


def start_quickly() -> None:
    """Collect cycles less often, and load what is imported but not used only if it is used."""
    gc.set_threshold(COLLECT_AFTER)
    # scipy copies the names of numpy, which imports numpy's Fortran wrapper generator; nothing here needs it.
    _load_on_use("numpy", "f2py")


def _load_on_use(package: str, name: str) -> None:
    """Make a submodule of an imported package load at the first use of one of its attributes."""
    parent, full = import_module(package), f"{package}.{name}"
    if full in sys.modules:
        return
    spec = find_spec(full)
    if spec is None or spec.loader is None:
        return
    spec.loader = LazyLoader(spec.loader)
    module = module_from_spec(spec)
    sys.modules[full] = module
    spec.loader.exec_module(module)
    setattr(parent, name, module)
