"""Kernels as other kernels see them: code that is linked into its callers and never runs by itself.

Numba optimises each function and turns it into machine code before it links it into its callers, where both happen
again: a body four calls deep is compiled four times. The libraries here keep the code as it was written, so it is
compiled once, with the kernel that is called from outside. This takes a cold start half as long.
"""

import itertools
from typing import Any, Self

from llvmlite import binding
from numba.core import codegen

from irsim_gym.base.kernels.passes import EntryCompiler

Library: Any = codegen.JITCodeLibrary
_numbers = itertools.count()


class _NoEngine:
    """Stands for Numba's execution engine, as there is nothing to run."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Do nothing: the environment is that of the caller."""


class InnerLibrary(Library):  # type: ignore[misc]
    """Code for linking alone."""

    codegen = _NoEngine

    @classmethod
    def restore(cls, generator: Any, serialized: Any) -> Self:
        """Make a library from what is on disk, without the machine code that Numba would make of it.

        Args:
            generator: Numba's code generator.
            serialized: From ``serialize_using_object_code``.
        """
        name, _, bitcode = serialized
        library = cls(generator, name)
        # Numba would optimise the module and emit machine code here; linking needs neither.
        library._final_module = binding.parse_bitcode(bitcode)
        library._finalize_final_module()
        return library

    def _optimize_final_module(self) -> None:
        """Do nothing: the caller's library is optimised."""

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


class InnerCompiler(EntryCompiler):
    """The compiler with fewer passes, and such a library for its results."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, target, library or InnerLibrary(target.codegen(), f"inner{next(_numbers)}"), *rest)
