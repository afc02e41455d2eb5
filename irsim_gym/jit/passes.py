"""Numba's passes for a kernel of the package, without those that find nothing in it.

The passes left out handle what no kernel of the package contains: closures, comprehensions, array expressions, literal
tuples, messages made at run time. This saves a tenth of a cold start. Other kernels go through all passes, as do those
that allocate.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numba.core import compiler

from irsim_gym.jit.lowering import KernelLowering
from irsim_gym.jit.resolution import Typing

PACKAGE = str(Path(__file__).parents[1])
NEEDLESS = {
    "WithLifting",
    "InlineClosureLikes",
    "RewriteSemanticConstants",
    "RewriteDynamicRaises",
    "MakeFunctionToJitFunction",
    "InlineInlinables",
    "FindLiterallyCalls",
    "LiteralUnroll",
    "LiteralPropagationSubPipelinePass",
    "InlineOverloads",
    "NopythonRewrites",
    "NoPythonSupportedFeatureValidation",
    "DumpParforDiagnostics",
}
Compiler: Any = compiler.Compiler


def pipelines(state: Any) -> list[Any]:
    """Return the passes for a function, in the form that Numba's compilers give; none is made twice."""
    manager: Any = compiler.DefaultPassBuilder.define_nopython_pipeline(state)  # type: ignore[no-untyped-call]
    if not state.flags.nrt and state.func_id.filename.startswith(PACKAGE):
        is_bare = not state.flags.debuginfo and not state.targetctx.enable_boundscheck
        lowering = {"NativeLowering": KernelLowering} if is_bare else {}
        passes = {lowering.get(one.__name__, one): why for one, why in manager.passes if one.__name__ not in NEEDLESS}
        state.typingctx = Typing(state.typingctx)
        if is_bare:
            # It writes where variables end, for counting references; what each pass leaves is in order as it is.
            passes = {one: why for one, why in passes.items() if one.__name__ != "IRLegalization"}
            manager._ENFORCING = False
        manager.passes[:] = passes.items()
        manager.finalize()
    return [manager]


class EntryCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler, with fewer passes."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes, by Numba's name for them."""
        return pipelines(self.state)
