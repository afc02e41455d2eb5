"""Numba's passes for a kernel of the package, without those that find nothing in it.

The passes left out handle what no kernel of the package contains: closures, comprehensions, array expressions, literal
tuples, messages made at run time. This saves a tenth of a cold start. Other kernels go through all passes, as do those
that allocate.
"""

from pathlib import Path
from typing import Any

from numba.core import compiler

from irsim_gym.base.kernels.lowering import KernelLowering
from irsim_gym.base.kernels.resolution import Typing

PACKAGE = str(Path(__file__).parents[2])
NEEDLESS = {"WithLifting", "InlineClosureLikes", "RewriteSemanticConstants", "RewriteDynamicRaises", "InlineOverloads"}
NEEDLESS |= {"MakeFunctionToJitFunction", "InlineInlinables", "FindLiterallyCalls", "LiteralUnroll", "NopythonRewrites"}
NEEDLESS |= {"LiteralPropagationSubPipelinePass", "NoPythonSupportedFeatureValidation", "DumpParforDiagnostics"}
KERNEL_LOWERING = {"NativeLowering": KernelLowering}
Compiler: Any = compiler.Compiler


class EntryCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler, with fewer passes."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes for a function, in the form that Numba's compilers give; none is made twice."""
        state: Any = self.state
        manager: Any = compiler.DefaultPassBuilder.define_nopython_pipeline(state)  # type: ignore[no-untyped-call]
        if not state.flags.nrt and state.func_id.filename.startswith(PACKAGE):
            needless, lowering = NEEDLESS, {}
            if not state.flags.debuginfo and not state.targetctx.enable_boundscheck:
                # That pass writes where variables end, which is for counts; what passes leave is in order as it is.
                needless, lowering, manager._ENFORCING = NEEDLESS | {"IRLegalization"}, KERNEL_LOWERING, False
            state.typingctx = Typing(state.typingctx)
            passes = {
                lowering.get(step.__name__, step): why for step, why in manager.passes if step.__name__ not in needless
            }
            manager.passes[:] = passes.items()
            manager.finalize()
        return [manager]
