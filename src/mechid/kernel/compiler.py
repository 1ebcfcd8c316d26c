"""Numba options and passes for kernels: inner functions are linked into their callers and optimised there.

By default Numba optimises each function together with its callees and generates its machine code before it compiles the
callers. A rate function with five callers is then optimised six times, and its own machine code is never executed.
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
def cache_signatures() -> Iterator[None]:
    """Let Numba resolve the signature of an operator on numbers once, not at each place of use.

    Numba searches all its signatures of ``+`` several times for each of about two thousand operations of a kernel. A
    signature depends on the types alone. Not thread-safe.
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

    # A method of Numba's own class is replaced here, and restored whatever happens inside.
    functions.get_call_type = get_call_type
    try:
        yield
    finally:
        functions.get_call_type = look_up


class InnerLibrary(JITCodeLibrary):
    """Code of an inner function, to be linked into its callers."""

    def _optimize_final_module(self) -> None:
        """Leave the optimisation to the caller's library."""

    def _finalize_final_module(self) -> None:
        """Generate no machine code."""
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
class InnerLowering(NativeLowering):
    """Lowering of a function that is called from compiled code only."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower the function into an `InnerLibrary` and register it with its callers under a unique key."""
        state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)  # type: ignore[no-untyped-call]
        state.library.enable_object_caching()
        # The caller's library produces the machine code.
        state.flags.no_compile = True
        super().run_pass(state)  # type: ignore[no-untyped-call]
        own: list[object] = []
        # A bound method of a new list is unique for each function; the table of callees requires a built-in function,
        # which is never called.
        key = own.append
        state.cr = state.cr._replace(cfunc=key)
        state.targetctx.insert_user_function(key, state.cr.fndesc, [state.library])
        return True


class KernelCompiler(CompilerBase):
    """Numba's compiler without the passes that no kernel needs: closures, ``with``, inlined and rewritten Python."""

    def define_pipelines(self) -> list[Any]:
        """Return the compiler passes for a kernel."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)  # type: ignore[no-untyped-call]
        passes.passes = [self.replace_pass(one) for one in passes.passes if one[0] not in UNNEEDED]
        passes.finalize()
        return [passes]

    def replace_pass(self, one: tuple[Any, str]) -> tuple[Any, str]:
        """Return the replacement of a pass."""
        return one


class InnerCompiler(KernelCompiler):
    """Compiler for functions that are called from compiled code only."""

    def replace_pass(self, one: tuple[Any, str]) -> tuple[Any, str]:
        """Return `InnerLowering` in place of Numba's lowering."""
        return (InnerLowering, "inner lowering") if one[0] is NativeLowering else one


PLAIN: Options = {"error_model": "numpy", "no_cfunc_wrapper": True, "no_rewrites": True}
INNER: Options = {**PLAIN, "no_cpython_wrapper": True, "pipeline_class": InnerCompiler}
"""Options of a function that is called from compiled code only."""
ENTRY: Options = {**PLAIN, "cache": True, "nogil": True, "pipeline_class": KernelCompiler}
"""Options of a function that is called from Python."""
