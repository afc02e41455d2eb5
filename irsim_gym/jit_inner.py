"""Kernels as other kernels see them: code to be taken in, which is never run by itself.

Numba optimises each function and turns it into machine code before it links it into its callers, where all that is
done again. A body that is four calls deep is compiled four times. Here it is handed on as it was written, and compiled
once with the kernel that is called from outside: a fifth of a cold start.
"""

from __future__ import annotations

import itertools
from typing import Any

from llvmlite import binding
from numba.core import codegen, compiler

from irsim_gym.jit_passes import pipelines

Library: Any = codegen.JITCodeLibrary
Compiler: Any = compiler.Compiler
_numbers = itertools.count()


class _NoEngine:
    """Stands for the engine that runs code, where there is nothing to run."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Do nothing: the environment is that of the caller."""


class InnerLibrary(Library):  # type: ignore[misc]
    """Code for linking alone."""

    codegen = _NoEngine

    @classmethod
    def restore(cls, machine: Any, kept: Any) -> InnerLibrary:
        """Make a library from what was kept of it: Numba would turn it into machine code, which nobody calls."""
        name, _, bitcode = kept
        library = cls(machine, name)
        library._final_module = binding.parse_bitcode(bitcode)
        library._finalize_final_module()
        return library

    def _optimize_final_module(self) -> None:
        """Leave it to the caller's library."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: nothing has an address."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> Any:
        """Return what is kept on disk: there is no machine code."""
        return self.serialize_using_bitcode()


class InnerCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler, whose results go into such a library."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, target, library or InnerLibrary(target.codegen(), f"inner{next(_numbers)}"), *rest)

    def define_pipelines(self) -> list[Any]:
        """Return the passes, by Numba's name for them."""
        return pipelines(self.state)
