"""Vector instructions inside numba kernels: the innermost steps, on four doubles at a time.

The compiler does not vectorise these by itself: it cannot know that inputs and outputs, many addresses at
distances known only at run time, are apart. Each function here emits the instructions for four
consecutive doubles, on any processor. Nothing checks bounds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic

__all__ = ["LANES", "ROWS", "add_rows", "butterfly", "twist", "twist_add"]

LANES = 4
#: Rows that are summed before they are stored.
ROWS = 4
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_FUSE = ("contract",)

Pair = tuple[Any, Any]  # real and imaginary part


class _Emitter:
    """Loads, stores and complex arithmetic of vectors in the function that is being built."""

    def __init__(self, context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> None:
        self._builder = builder
        self.args = [
            context.make_array(kind)(context, builder, value=value).data
            if isinstance(kind, types.Array)
            else value
            for kind, value in zip(signature.args, args, strict=True)
        ]

    def _address(self, array: Any, at: Any) -> Any:
        return self._builder.bitcast(self._builder.gep(array, [at]), _VECTOR.as_pointer())

    def load(self, array: Any, at: Any) -> Any:
        """Four doubles from array[at]."""
        return self._builder.load(self._address(array, at), align=8)

    def store(self, value: Any, array: Any, at: Any) -> None:
        """Four doubles to array[at]."""
        self._builder.store(value, self._address(array, at), align=8)

    def spread(self, scalar: Any) -> Any:
        """Return one number in all four places."""
        one = self._builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), scalar, ir.IntType(32)(0))
        places = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return self._builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), places)

    def scalar(self, array: Any, at: Any) -> Any:
        """Return array[at] in all four places."""
        return self.spread(self._builder.load(self._builder.gep(array, [at])))

    def number(self, value: float) -> Any:
        """Return a constant in all four places."""
        return ir.Constant(_VECTOR, [value] * LANES)

    def offset(self, at: Any, step: Any, times: int) -> Any:
        """Return at + times * step."""
        return self._builder.add(at, self._builder.mul(step, ir.Constant(step.type, times)))

    def plus(self, a: Any, b: Any) -> Any:
        """Sum."""
        return self._builder.fadd(a, b, flags=_FUSE)

    def minus(self, a: Any, b: Any) -> Any:
        """Difference."""
        return self._builder.fsub(a, b, flags=_FUSE)

    def times(self, a: Any, b: Any) -> Any:
        """Product."""
        return self._builder.fmul(a, b, flags=_FUSE)

    def add(self, a: Pair, b: Pair) -> Pair:
        """Complex sum."""
        return self.plus(a[0], b[0]), self.plus(a[1], b[1])

    def subtract(self, a: Pair, b: Pair) -> Pair:
        """Complex difference."""
        return self.minus(a[0], b[0]), self.minus(a[1], b[1])

    def add_turned(self, a: Pair, b: Pair) -> Pair:
        """Complex a + i b."""
        return self.minus(a[0], b[1]), self.plus(a[1], b[0])

    def subtract_turned(self, a: Pair, b: Pair) -> Pair:
        """Complex a - i b."""
        return self.plus(a[0], b[1]), self.minus(a[1], b[0])

    def multiply(self, a: Pair, b: Pair) -> Pair:
        """Complex product."""
        real = self.minus(self.times(a[0], b[0]), self.times(a[1], b[1]))
        return real, self.plus(self.times(a[0], b[1]), self.times(a[1], b[0]))

    def combine(self, weights: Sequence[float], terms: Sequence[Pair], start: Pair | None = None) -> Pair:
        """Real weights times complex terms, summed."""
        total = start
        for weight, term in zip(weights, terms, strict=True):
            w = self.number(weight)
            scaled = self.times(w, term[0]), self.times(w, term[1])
            total = scaled if total is None else self.add(total, scaled)
        assert total is not None
        return total


def _transform(e: _Emitter, a: list[Pair]) -> list[Pair]:
    """Return sum_k a_k exp(2 pi i k l / r) of r = len(a) numbers: 2, 4 or odd."""
    r = len(a)
    if r == 2:
        return [e.add(a[0], a[1]), e.subtract(a[0], a[1])]
    if r == 4:
        even, odd = e.add(a[0], a[2]), e.add(a[1], a[3])
        even_less, odd_less = e.subtract(a[0], a[2]), e.subtract(a[1], a[3])
        return [
            e.add(even, odd),
            e.add_turned(even_less, odd_less),
            e.subtract(even, odd),
            e.subtract_turned(even_less, odd_less),
        ]
    half = range(1, r // 2 + 1)
    sums, differences = [e.add(a[k], a[r - k]) for k in half], [e.subtract(a[k], a[r - k]) for k in half]
    out = [a[0]] * r
    for term in sums:
        out[0] = e.add(out[0], term)
    for m in half:
        angle = [2.0 * math.pi * m * k / r for k in half]
        real = e.combine([math.cos(x) for x in angle], sums, a[0])
        turned = e.combine([math.sin(x) for x in angle], differences)
        out[m], out[r - m] = e.add_turned(real, turned), e.subtract_turned(real, turned)
    return out


def _emit_butterfly(e: _Emitter, r: int) -> None:
    x_re, x_im, at, step, w_re, w_im, w, y_re, y_im, to, out_step = e.args[1:]
    places = [e.offset(at, step, k) for k in range(r)]
    values = _transform(e, [(e.load(x_re, p), e.load(x_im, p)) for p in places])
    for k, value in enumerate(values):
        if k > 0:
            index = e.offset(w, ir.Constant(w.type, 1), k - 1)
            value = e.multiply(value, (e.scalar(w_re, index), e.scalar(w_im, index)))
        place = e.offset(to, out_step, k)
        e.store(value[0], y_re, place)
        e.store(value[1], y_im, place)


_PLACE = types.intp


def _butterfly_signature(radix: Any, x: Any, w: Any, y: Any) -> Any:
    return types.void(radix, x, x, _PLACE, _PLACE, w, w, _PLACE, y, y, _PLACE, _PLACE)


@intrinsic(prefer_literal=True)
def butterfly(typing, radix, x_re, x_im, at, step, w_re, w_im, w, y_re, y_im, to, out_step):
    """Transform x[at + k step], multiply by w[w + k - 1] and put into y[to + k out_step], k < radix."""

    def generate(context, builder, signature, args):
        _emit_butterfly(_Emitter(context, builder, signature, args), radix.literal_value)
        return context.get_dummy_value()

    return _butterfly_signature(radix, x_re, w_re, y_re), generate


def _emit_twist(e: _Emitter, *, add: bool) -> None:
    t_re, t_im, at, a_re, a_im, b_re, b_im, x_re, x_im, plus, minus = e.args
    turn = e.load(t_re, at), e.load(t_im, at)
    back = turn[0], e.minus(e.number(0.0), turn[1])
    for place, factor, value in ((plus, turn, (a_re, a_im)), (minus, back, (b_re, b_im))):
        product = e.multiply(factor, (e.spread(value[0]), e.spread(value[1])))
        if add:
            product = e.add(product, (e.load(x_re, place), e.load(x_im, place)))
        e.store(product[0], x_re, place)
        e.store(product[1], x_im, place)


def _twist_signature(t: Any, x: Any) -> Any:
    number = types.float64
    return types.void(t, t, _PLACE, number, number, number, number, x, x, _PLACE, _PLACE)


@intrinsic
def twist(typing, t_re, t_im, at, a_re, a_im, b_re, b_im, x_re, x_im, plus, minus):
    """Set x[plus] to t[at] a and x[minus] to conj(t[at]) b."""

    def generate(context, builder, signature, args):
        _emit_twist(_Emitter(context, builder, signature, args), add=False)
        return context.get_dummy_value()

    return _twist_signature(t_re, x_re), generate


@intrinsic
def twist_add(typing, t_re, t_im, at, a_re, a_im, b_re, b_im, x_re, x_im, plus, minus):
    """Add t[at] a to x[plus] and conj(t[at]) b to x[minus]."""

    def generate(context, builder, signature, args):
        _emit_twist(_Emitter(context, builder, signature, args), add=True)
        return context.get_dummy_value()

    return _twist_signature(t_re, x_re), generate


def _emit_rows(e: _Emitter) -> None:
    table, e_re, e_im, start, out_re, out_im, at = e.args[:7]
    places, factors = e.args[7 : 7 + ROWS], e.args[7 + ROWS :]
    total = e.load(out_re, at), e.load(out_im, at)
    for r, place in enumerate(places):
        index = e.offset(start, ir.Constant(start.type, 1), -r)
        weight = e.load(table, place)
        term = e.times(weight, e.load(e_re, index)), e.times(weight, e.load(e_im, index))
        total = e.add(total, e.multiply((e.spread(factors[2 * r]), e.spread(factors[2 * r + 1])), term))
    e.store(total[0], out_re, at)
    e.store(total[1], out_im, at)


@intrinsic
def add_rows(
    typing, table, e_re, e_im, start, out_re, out_im, at, t0, t1, t2, t3, a0, b0, a1, b1, a2, b2, a3, b3
):
    """Add sum_r table[t_r] (a_r + i b_r) e[start - r] to out[at], four consecutive ones of each."""

    def generate(context, builder, signature, args):
        _emit_rows(_Emitter(context, builder, signature, args))
        return context.get_dummy_value()

    places, numbers = [_PLACE] * ROWS, [types.float64] * (2 * ROWS)
    signature = types.void(table, e_re, e_im, _PLACE, out_re, out_im, _PLACE, *places, *numbers)
    return signature, generate
