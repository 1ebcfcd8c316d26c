"""Numba intrinsics that move four numbers of a kernel at a time, as one vector.

`mechid.kernel.loop.fours` states the same in plain text, which the C export prints.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

_FOUR = ir.VectorType(ir.DoubleType(), 4)
_INDEX = ir.IntType(32)
_EVEN, _ODD, _LOW, _HIGH = (0, 4, 2, 6), (1, 5, 3, 7), (0, 1, 4, 5), (2, 3, 6, 7)


@intrinsic
def put_four(typing: Any, w: Any, at: Any, a: Any, b: Any, c: Any, d: Any, one: Any) -> Any:
    """Write four numbers side by side, each times `one`, which is 1.

    A vector load that follows four stores of single numbers waits until they have left the processor's store buffer;
    one that follows a vector store does not. LLVM splits the store of a vector that was only put together, but not that
    of a product.
    """
    del typing

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        w, at, *numbers, one = arguments
        value = ones = ir.Constant(_FOUR, ir.Undefined)
        for i, number in enumerate(numbers):
            value = builder.insert_element(value, number, ir.Constant(_INDEX, i))
        ones = _shuffle(builder, builder.insert_element(ones, one, ir.Constant(_INDEX, 0)), ones, (0, 0, 0, 0))
        _store(builder, w, at, builder.fmul(value, ones))
        return context.get_dummy_value()

    return types.void(w, types.int64, *(5 * [types.float64])), code


@intrinsic
def copy_four(typing: Any, target: Any, to: Any, source: Any, at: Any) -> Any:
    """Copy four numbers from `at` of one array to `to` of another."""
    del typing

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        target, to, source, at = arguments
        _store(builder, target, to, _load(builder, source, at))
        return context.get_dummy_value()

    return types.void(target, types.int64, source, types.int64), code


@intrinsic
def put_turned(  # noqa: PLR0913, PLR0917 (four columns have four places)
    typing: Any, w: Any, to: Any, a: Any, b: Any, c: Any, d: Any, scale: Any, add: Any
) -> Any:
    """Write four adjacent rows from `to` on, whose columns stand at a to d, times the row at `scale`.

    With `add`, which is not zero, they are added to what stands there.
    """
    del typing

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        del signature
        w, to, *columns, scale, add = arguments
        a, b, c, d = (_load(builder, w, at) for at in columns)
        even, odd = ((_shuffle(builder, a, b, order), _shuffle(builder, c, d, order)) for order in (_EVEN, _ODD))
        rows = [_shuffle(builder, *pair, order) for order in (_LOW, _HIGH) for pair in (even, odd)]
        factor = _load(builder, w, scale)
        rows = [builder.fmul(row, factor) for row in rows]
        places = [builder.add(to, ir.Constant(to.type, 4 * i)) for i in range(4)]
        with builder.if_else(builder.icmp_signed("!=", add, ir.Constant(add.type, 0))) as (more, first):
            with more:
                for place, row in zip(places, rows, strict=True):
                    _store(builder, w, place, builder.fadd(row, _load(builder, w, place)))
            with first:
                for place, row in zip(places, rows, strict=True):
                    _store(builder, w, place, row)
        return context.get_dummy_value()

    return types.void(w, *(7 * [types.int64])), code


def _place(builder: Any, w: Any, at: Any) -> Any:
    return builder.bitcast(builder.gep(w, [at]), _FOUR.as_pointer())


def _load(builder: Any, w: Any, at: Any) -> Any:
    return builder.load(_place(builder, w, at), align=8)


def _store(builder: Any, w: Any, at: Any, value: Any) -> None:
    builder.store(value, _place(builder, w, at), align=8)


def _shuffle(builder: Any, a: Any, b: Any, order: tuple[int, ...]) -> Any:
    """Return the elements of two vectors in another order, those of the second counted from 4."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, 4), order))
