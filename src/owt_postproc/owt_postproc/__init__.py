"""Post-processing: rainflow counting, damage, spectra, bags, report.

:func:`rainflow` is imported on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from owt_postproc.core.rainflow import rainflow

__all__ = ["rainflow"]


def __getattr__(name: str) -> Any:
    """Import what is asked for."""
    if name == "rainflow":
        from owt_postproc.core.rainflow import rainflow as function

        return function
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
