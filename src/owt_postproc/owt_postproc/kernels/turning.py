"""Turning points of smooth signals, eight samples at a time.

Most samples of a response lie on a slope: between a lower and a higher neighbour. Leaving them out changes
no cycle, and what is left is a few percent. The compiler does not vectorise a loop that keeps some samples:
the comparison of eight samples with their neighbours is written as vector instructions, on any processor.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit, types
from numba.extending import intrinsic

__all__ = ["keep_turning", "warm_up"]

LANES = 8
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)


@intrinsic
def _turning_mask(typing, x, at):
    """Bit k is set unless x[at + k] lies strictly between its two neighbours. Nothing checks bounds."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, value=args[0]).data

        def load(offset: int) -> Any:
            place = builder.add(args[1], ir.Constant(args[1].type, offset))
            return builder.load(builder.bitcast(builder.gep(data, [place]), _VECTOR.as_pointer()), align=8)

        before, here, after = load(-1), load(0), load(1)

        def between(less: str) -> Any:
            return builder.and_(
                builder.fcmp_ordered(less, before, here), builder.fcmp_ordered(less, here, after)
            )

        sloping = builder.or_(between("<"), between(">"))
        return builder.zext(builder.not_(builder.bitcast(sloping, ir.IntType(LANES))), ir.IntType(64))

    return types.int64(x, types.intp), generate


@intrinsic
def _lowest_bit(typing, mask):
    """Place of the lowest bit of a mask that is not zero."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(types.int64), generate


@njit(cache=True, nogil=True)
def keep_turning(signal, kept):
    """Copy the samples that do not lie on a slope, the first and the last one always; returns their number.

    `signal` holds one finite sample or more, `kept` (as long) receives them.
    """
    n = signal.size
    kept[0] = signal[0]
    found, i = 1, 1
    while i + LANES < n:
        mask = _turning_mask(signal, i)
        while mask != 0:
            kept[found] = signal[i + _lowest_bit(mask)]
            found += 1
            mask &= mask - 1
        i += LANES
    while i < n - 1:
        before, here, after = signal[i - 1], signal[i], signal[i + 1]
        if not ((before < here < after) or (before > here > after)):
            kept[found] = here
            found += 1
        i += 1
    if n > 1:
        kept[found] = signal[n - 1]
        found += 1
    return found


def warm_up() -> None:
    """Compile for the array types in use."""
    keep_turning(np.zeros(12), np.zeros(12))
