"""The name of a reduction, read once.

``full``: none. ``auto``: the smallest basis that meets ``structure.tolerance``. Otherwise

    [CBnn][Mmm][Y][jk][+SIM]

nn fixed-interface modes (``CB00`` is Guyan's reduction), mm modal truncation augmentation vectors made from
as many vectors of the loads, Y the six made from interface accelerations, of all orders 0 to k (thesis
eq. 3.53; order 0 only without ``jk``), and static improvement: the static response of what the basis leaves
out, added in recovery. Numbers have two or three digits, k one. ``CB10M10j1Y`` has 10 modes and
(10 + 6) * 2 vectors; the order of Y and jk is free, and so is the plus sign.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from owt_model.errors import InputError

__all__ = ["AUTO_MODES", "AUTO_VECTORS", "ReductionName", "parse_reduction"]

#: Fixed-interface modes and augmentation vectors that ``auto`` chooses from, each with each.
AUTO_MODES = (0, 5, 10, 15, 20, 30, 40)
AUTO_VECTORS = (0, 5, 10, 15, 20, 30)

_PATTERN = re.compile(
    r"^(?:CB(?P<modes>\d{2,3}))?(?:M(?P<vectors>\d{2,3}))?"
    r"(?P<before>Y)?(?:j(?P<order>\d))?(?P<after>Y)?(?P<improved>\+?SIM)?$"
)
_FORMS = "must be full, CBnn, CBnnMmm or Mmm (nn, mm two or three digits), with jk, Y or +SIM behind, or auto"
_EXAMPLES = "For example CB10M10: 10 fixed-interface modes and 10 MTA vectors; CB10M10j1Y, CB20+SIM, auto."


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
        Number of vectors of the load basis that augmentation vectors are made from; for ``auto`` as many as
        it may come to use.
    order : int
        Highest order j of the augmentation vectors.
    interface_vectors : bool
        Whether interface accelerations give augmentation vectors too.
    static_improvement : bool
        Whether the static response of what the basis leaves out is added.
    auto : bool
        Whether the rest is to be chosen.
    """

    full: bool
    fixed_interface_modes: int
    load_vectors: int
    order: int = 0
    interface_vectors: bool = False
    static_improvement: bool = False
    auto: bool = False


def parse_reduction(name: str) -> ReductionName:
    """Return what the reduction `name` is made of.

    Raises
    ------
    InputError
        If it is not a reduction.
    """
    if name == "full":
        return ReductionName(full=True, fixed_interface_modes=0, load_vectors=0)
    if name == "auto":
        return ReductionName(False, AUTO_MODES[-1], AUTO_VECTORS[-1], auto=True)
    match = _PATTERN.match(name)
    if match is None or not name or (match["before"] and match["after"]):
        raise InputError("structure.reduction", name, _FORMS, _EXAMPLES)
    parsed = ReductionName(
        full=False,
        fixed_interface_modes=int(match["modes"] or 0),
        load_vectors=int(match["vectors"] or 0),
        order=int(match["order"] or 0),
        interface_vectors=bool(match["before"] or match["after"]),
        static_improvement=bool(match["improved"]),
    )
    vectors = parsed.interface_vectors or parsed.load_vectors
    if match["order"] and not vectors:
        raise InputError(
            "structure.reduction", name, "gives an order jk of no vectors", "Add Mmm or Y, or leave jk out."
        )
    if not (match["modes"] or vectors):
        raise InputError("structure.reduction", name, _FORMS, _EXAMPLES)
    return parsed
