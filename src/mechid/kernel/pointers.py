"""Numba intrinsics for kernels: bare pointers, calls by address and function attributes."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import intrinsic


@intrinsic
def numbers(typing: Any, array: Any) -> Any:
    """Return a flat array as a bare pointer, without shape and without negative indices.

    The code compiled for it is a third shorter than for an array, and compiles correspondingly faster.
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
    """Call a kernel's `run` at its address with the given arguments and return its result.

    A call by name would compile and optimise the kernel again together with its caller, which takes longer than
    everything else there.
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
    """Return the address of a compiled function, which must have exactly one signature."""
    (overload,) = function.overloads.values()
    return int(overload.library.get_pointer_to_function(overload.fndesc.llvm_func_name))


def _attribute(*names: str) -> Any:
    """Return an intrinsic that adds LLVM attributes to the function that contains the call."""

    @intrinsic
    def add_attributes(typing: Any) -> Any:
        del typing

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            del signature, arguments
            for name in names:
                builder.function.attributes.add(name)
            return context.get_dummy_value()

        return types.void(), code

    return add_attributes


in_vectors = _attribute("optsize")
"""Marks a function of short loops over sets. The optimiser would unroll these loops completely before it recognises
that they vectorise; optimised for size, it leaves them as loops."""
apart = _attribute("noinline")
"""Marks a function that is compiled once, however often it is called."""
rarely = _attribute("noinline", "optsize", "cold")
"""Marks a function that is rarely called and not worth optimising."""
