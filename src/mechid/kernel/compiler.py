"""How Numba compiles a kernel: the functions within it are joined to those that call them, and optimised there.

By itself Numba optimises each function with all that it calls, and makes machine code of it, before the function that
calls it is begun: a rate that five functions call is optimised six times, and its own machine code nobody runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import InlineOverloads, NativeLowering
from numba.core.types.functions import BaseFunction
from numba.core.untyped_passes import (
    FindLiterallyCalls,
    InlineClosureLikes,
    InlineInlinables,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    RewriteDynamicRaises,
    WithLifting,
)

Options: TypeAlias = dict[str, Any]
NUMBERS = (types.Number, types.Boolean, types.CPointer, types.Literal)
UNNEEDED = {
    FindLiterallyCalls,
    InlineClosureLikes,
    InlineInlinables,
    InlineOverloads,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    RewriteDynamicRaises,
    WithLifting,
}


@contextmanager
def signatures_remembered() -> Iterator[None]:
    """Let Numba find the signature of an operator on numbers once within, and not for each place where it stands.

    It goes through all that it knows of ``+`` several times for each of some two thousand operations of a kernel. A
    signature depends on nothing but the types. Not for several threads at once.
    """
    functions: Any = BaseFunction
    look_up, found = functions.get_call_type, {}

    def get_call_type(self: BaseFunction, context: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        if kws or not all(isinstance(one, NUMBERS) for one in args):
            return look_up(self, context, args, kws)
        key = self, *args
        if key not in found:
            found[key] = look_up(self, context, args, kws)
        return found[key]

    functions.get_call_type = get_call_type
    try:
        yield
    finally:
        functions.get_call_type = look_up


class InnerLibrary(JITCodeLibrary):
    """Code that is there to be joined to that of its callers."""

    def _optimize_final_module(self) -> None:
        """Leave that to the caller's library."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
class InnerLowering(NativeLowering):
    """Lowering of a function that only compiled ones call."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower the function into an `InnerLibrary`, and make it known to its callers by a key of its own."""
        state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)  # type: ignore[no-untyped-call]
        state.library.enable_object_caching()
        state.flags.no_compile = True
        super().run_pass(state)  # type: ignore[no-untyped-call]
        own: list[object] = []
        key = own.append  # of each list another: the table of callees wants a built-in function, which nobody calls
        state.cr = state.cr._replace(cfunc=key)
        state.targetctx.insert_user_function(key, state.cr.fndesc, [state.library])
        return True


class KernelCompiler(CompilerBase):
    """Numba's compiler without its passes for what no kernel has: closures, ``with``, inlined and rewritten Python."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes that a kernel needs."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)  # type: ignore[no-untyped-call]
        passes.passes = [self.exchanged(one) for one in passes.passes if one[0] not in UNNEEDED]
        passes.finalize()
        return [passes]

    def exchanged(self, one: tuple[Any, str]) -> tuple[Any, str]:
        """Return what stands in place of a pass."""
        return one


class InnerCompiler(KernelCompiler):
    """The same for functions that only compiled ones call."""

    def exchanged(self, one: tuple[Any, str]) -> tuple[Any, str]:
        """Return the lowering in place of Numba's."""
        return (InnerLowering, "inner lowering") if one[0] is NativeLowering else one


PLAIN: Options = {"error_model": "numpy", "no_cfunc_wrapper": True, "no_rewrites": True}
INNER: Options = {**PLAIN, "no_cpython_wrapper": True, "pipeline_class": InnerCompiler}
"""Of a function that only compiled ones call."""
ENTRY: Options = {**PLAIN, "cache": True, "nogil": True, "pipeline_class": KernelCompiler}
"""Of a function that Python calls."""
