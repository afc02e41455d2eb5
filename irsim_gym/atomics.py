"""Words in memory that several threads read and write at the same time, for use in kernels.

Each function takes the address of an int64. Kernels that run as plain Python hold the GIL, and need none of this.
"""

from __future__ import annotations

import platform
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

WORD, NUMBER, NOTHING = ir.IntType(64), ir.IntType(32), ir.VoidType()
PAUSES = {
    "x86_64": ("llvm.x86.sse2.pause", []),
    "amd64": ("llvm.x86.sse2.pause", []),
    "aarch64": ("llvm.aarch64.hint", [ir.Constant(NUMBER, 1)]),
    "arm64": ("llvm.aarch64.hint", [ir.Constant(NUMBER, 1)]),
}
"""By processor, the instruction for a pause in a loop that waits, and its arguments."""


def _load(context: Any, address: Any) -> Any:
    """Return the word at an address, in one order with all stores: a thread sets its sleep flag, then looks again."""

    def generate(context: Any, build: Any, signature: Any, arguments: Any) -> Any:
        return build.load_atomic(_pointer(build, arguments[0]), "seq_cst", 8)

    return types.int64(types.int64), generate


def _store(context: Any, address: Any, value: Any) -> Any:
    """Write a value to an address; a thread that reads it also sees everything written before."""

    def generate(context: Any, build: Any, signature: Any, arguments: Any) -> Any:
        build.store_atomic(arguments[1], _pointer(build, arguments[0]), "seq_cst", 8)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


def _add(context: Any, address: Any, value: Any) -> Any:
    """Add a value to the word at an address, and return the word before."""

    def generate(context: Any, build: Any, signature: Any, arguments: Any) -> Any:
        return build.atomic_rmw("add", _pointer(build, arguments[0]), arguments[1], "seq_cst")

    return types.int64(types.int64, types.int64), generate


def _swap(context: Any, address: Any, value: Any) -> Any:
    """Write a value to an address, and return the word before."""

    def generate(context: Any, build: Any, signature: Any, arguments: Any) -> Any:
        return build.atomic_rmw("xchg", _pointer(build, arguments[0]), arguments[1], "seq_cst")

    return types.int64(types.int64, types.int64), generate


def _relax(context: Any) -> Any:
    """Pause the processor for a moment, in a loop that waits."""

    def generate(context: Any, build: Any, signature: Any, arguments: Any) -> Any:
        name, given = PAUSES.get(platform.machine().lower(), ("", []))
        if name:
            kind = ir.FunctionType(NOTHING, [one.type for one in given])
            build.call(build.module.declare_intrinsic(name, fnty=kind), given)
        return context.get_dummy_value()

    return types.void(), generate


def _pointer(build: Any, address: Any) -> Any:
    return build.inttoptr(address, WORD.as_pointer())


load: Any = intrinsic(_load)
store: Any = intrinsic(_store)
add: Any = intrinsic(_add)
swap: Any = intrinsic(_swap)
relax: Any = intrinsic(_relax)
