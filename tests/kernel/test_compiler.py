"""How Numba compiles a kernel."""

import itertools
import operator

import numba
from numba.core import types
from numba.core.registry import cpu_target
from numba.core.types.functions import BaseFunction

from mechid.kernel.compiler import cache_signatures

OPERATORS = (operator.add, operator.sub, operator.mul, operator.truediv, operator.lt, operator.and_, abs, min)
SCALARS = (types.float64, types.int64, types.intp, types.boolean, types.literal(3), types.literal(-1))


def signature(function, args):
    """Return the signature of a function on types, or None where it has none."""
    context = cpu_target.typing_context
    context.refresh()
    try:
        return context.resolve_function_type(context.resolve_value_type(function), args, {})
    except numba.TypingError:
        return None


def test_a_signature_that_is_remembered_is_the_one_that_is_looked_up():
    """Truth: Numba by itself, asked before and after."""
    cases = [
        (one, pair[: 1 if one is abs else 2]) for one in OPERATORS for pair in itertools.product(SCALARS, repeat=2)
    ]
    before = [signature(*case) for case in cases]
    look_up = BaseFunction.get_call_type
    with cache_signatures():
        assert BaseFunction.get_call_type is not look_up
        for _ in range(2):
            assert [signature(*case) for case in cases] == before
    assert BaseFunction.get_call_type is look_up
    assert sum(one is not None for one in before) > 200


def test_what_is_compiled_within_computes_the_same():
    def mixed(a, n):
        return (a + n) * 3 - min(a, 2.0) / (n + 1) + (a < n)

    with cache_signatures():
        compiled = numba.njit(mixed)
        found = [compiled(a, n) for a, n in ((0.5, 2), (-1.5, 7), (3.25, -4))]
    assert found == [mixed(a, n) for a, n in ((0.5, 2), (-1.5, 7), (3.25, -4))]
