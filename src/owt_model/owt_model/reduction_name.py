"""The name of a reduction, read once: ``full``, ``CBnn``, ``CBnnMmm`` or ``Mmm``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from owt_model.errors import InputError

__all__ = ["ReductionName", "parse_reduction"]

_PATTERN = re.compile(r"^(?:CB(?P<modes>\d{2,3}))?(?:M(?P<vectors>\d{2,3}))?$")


@dataclass(frozen=True)
class ReductionName:
    """What a reduction is made of.

    Attributes
    ----------
    full : bool
        No reduction at all.
    fixed_interface_modes : int
        Number of Craig-Bampton modes.
    load_vectors : int
        Number of augmentation vectors, each made from one vector of the load basis.
    """

    full: bool
    fixed_interface_modes: int
    load_vectors: int


def parse_reduction(name: str) -> ReductionName:
    """Return what the reduction `name` is made of.

    Raises
    ------
    InputError
        If it is not a reduction.
    """
    if name == "full":
        return ReductionName(full=True, fixed_interface_modes=0, load_vectors=0)
    match = _PATTERN.match(name)
    if not name or match is None:
        raise InputError(
            "structure.reduction",
            name,
            "must be full, CBnn, CBnnMmm or Mmm (nn, mm two or three digits)",
            "For example CB10M10: 10 fixed-interface modes and 10 MTA vectors.",
        )
    return ReductionName(False, int(match["modes"] or 0), int(match["vectors"] or 0))
