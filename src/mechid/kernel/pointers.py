"""What a kernel's text needs of Numba beyond the language: arrays as bare pointers, calls by address."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import intrinsic


@intrinsic
def numbers(typing: Any, array: Any) -> Any:
    """Return the numbers of a flat array by their places alone: no shape, nothing counts from the end.

    What is compiled for them is a third shorter than for the array, and compiles so much sooner.
    """
    del typing

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, arguments[0]).data

    return types.CPointer(array.dtype)(array), code  # type: ignore[no-untyped-call]


@intrinsic
def called(  # noqa: PLR0913, PLR0917 (the arguments of a kernel's run)
    typing: Any,
    address: Any,
    p: Any,
    directions: Any,
    sensitive: Any,
    grid: Any,
    times: Any,
    values: Any,
    discrete: Any,
    w: Any,
    y: Any,
    y_dot: Any,
    J: Any,
    events: Any,
) -> Any:
    """Return what a kernel's `run` gives for these arguments, called at its address.

    Named in the text it would be compiled and optimised again together with its caller, which takes longer than all
    else there.
    """
    del typing
    arguments = (p, directions, sensitive, grid, times, values, discrete, w, y, y_dot, J, events)

    def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        convention = context.call_conv
        kind = convention.get_function_type(signature.return_type, arguments)
        function = builder.inttoptr(values[0], kind.as_pointer())
        status, result = convention.call_function(builder, function, signature.return_type, arguments, values[1:])
        with builder.if_then(status.is_error, likely=False):
            convention.return_status_propagate(builder, status)
        return result

    return types.int64(types.int64, *arguments), code


def address_of(function: Any) -> int:
    """Return the address of a compiled function that has been called with arguments of one kind alone."""
    (overload,) = function.overloads.values()
    return int(overload.library.get_pointer_to_function(overload.fndesc.llvm_func_name))


def _attributed(*names: str) -> Any:
    """Return an intrinsic that gives the function in whose text it stands attributes of LLVM."""

    @intrinsic
    def attributed(typing: Any) -> Any:
        del typing

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature, arguments
            for name in names:
                builder.function.attributes.add(name)
            return context.get_dummy_value()

        return types.void(), code

    return attributed


in_vectors = _attributed("optsize")
"""A function of short loops over sets: the compiler would write them out one set after the other before it sees that
they could be vector instructions; where code is to be short it does not."""
apart = _attributed("noinline")
"""A function that is compiled once, however often it is called."""
rarely = _attributed("noinline", "optsize", "cold")
"""A function that is seldom called: no time is spent on making it fast."""
