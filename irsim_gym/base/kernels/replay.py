"""A list of kernel calls that runs as one call: the arguments are packed once, a compiled loop makes the calls.

Calling a kernel from Python costs some 50 ns for each array among its arguments, which Numba recognises, unpacks and
counts. Here all that happens once: every argument is taken apart into the machine words that the compiled function
expects (Numba's calling convention), and the kernel is compiled with a packed entry, which loads the words that it
needs (``base.kernels.packed``). A loop over packed entries is then a whole step.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Hashable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.errors import NumbaError
from numba.extending import intrinsic

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.kernels import Calls, Kernel, config, hooks, kernel
from irsim_gym.base.kernels.layout import COUNT, WORLDS
from irsim_gym.base.kernels.structs import NotPackableError, Struct, Words, words_of
from irsim_gym.base.kernels.workers import Job

BLOCK = 128
"""Worlds that all calls treat before the next ones: few enough to stay in the processor's cache."""

WORD, STATUS = ir.IntType(64), ir.IntType(32)
typed: Any = numba.typeof
OK, OK_NONE = 0, -2
"""The status of a function of Numba's that raised nothing, with and without a value."""

Packed = tuple[Any, str, "array[int]"]
"""An argument: its type by Numba, a letter for each of its words, and the words."""
GIVEN: Words = [("q", 0), ("q", 0), (COUNT, 0), ("q", 8), (WORLDS, 0), (COUNT, 0), ("q", 8)]
"""The array of the worlds to treat: address and number are filled in when the call is made."""


class NotRecordableError(Exception):
    """A call has an argument that cannot be packed, or returns a value."""


class Program:
    """Calls of kernels for any selection of worlds.

    Attributes:
        calls: The kernels with their arguments; held here, because the packed words point into the arrays.
        words: All arguments, packed.
        entries: Addresses of the packed entry and of the packed arguments of each call, shape ``(n_calls, 2)``.
    """

    def __init__(self, calls: Calls, worlds: Ints, compile_ahead: Callable[[], None] | None = None) -> None:
        """Pack recorded calls.

        Args:
            calls: From ``kernels.record``.
            worlds: The array that stands for the worlds to treat: each run replaces it by its own.
            compile_ahead: See ``PackedEntries.address``.

        Raises:
            NotRecordableError: A call cannot be packed.
        """
        self.calls = calls
        packer = Packer(worlds, compile_ahead)
        entries = [packer.add(called, arguments) for called, arguments in calls]
        self.words = np.array(packer.words, np.int64)
        self.entries = np.array(entries, np.int64).reshape(-1, 2)
        self.entries[:, 1] = self.words.ctypes.data + self.words.itemsize * self.entries[:, 1]
        self._make_calls: Callable[..., int] = make_calls.compiled  # type: ignore[attr-defined]

    def run(self, worlds: Ints) -> None:
        """Make all calls for the given worlds, shape ``(n,)``, contiguous."""
        failed = self._make_calls(self.entries, worlds, BLOCK)
        if failed:
            self.check(failed)

    def check(self, failed: int) -> None:
        """Raise an error if a call has failed; calls are counted from 1."""
        if failed:
            raise RuntimeError(f"{self.calls[failed - 1][0].__name__} failed; NUMBA_DISABLE_JIT=1 shows where")

    @property
    def address(self) -> int:
        """Where the calls stand that ``call_all`` makes."""
        return int(self.entries.ctypes.data)

    @property
    def n_calls(self) -> int:
        """How many there are."""
        return len(self.entries)

    def equals(self, other: Program) -> bool:
        """Return whether both make the same calls with the same arguments, which stay where they are."""
        return bool(np.array_equal(self.words, other.words) and np.array_equal(self.entries[:, 0], other.entries[:, 0]))


def is_possible() -> bool:
    """Return whether calls can be packed: kernels are compiled, without bounds checks, and Numba's hooks are usable."""
    return not config.DISABLE_JIT and not config.BOUNDSCHECK and hooks.are_usable()


class Packer:
    """Packs the arguments of calls, one after the other.

    A crowd whose members move in turns makes some ten thousand calls with the same arrays: each array is packed once.

    Attributes:
        words: All arguments so far, as machine words.
    """

    def __init__(self, worlds: Ints, compile_ahead: Callable[[], None] | None = None) -> None:
        self.words = array("q")
        self._compile_ahead = compile_ahead
        self._worlds = worlds
        self._known: dict[Hashable, Packed] = {}
        self._types: dict[Hashable, Any] = {}
        self._entries: dict[Hashable, int] = {}

    def add(self, called: Kernel, arguments: tuple[Any, ...]) -> tuple[int, int]:
        """Pack the arguments of a call; return the address of its packed entry and the place of its first word.

        The arguments have to live as long as the packer does: it knows arrays by their ``id``.

        Raises:
            NotRecordableError: One of them cannot be packed, or the kernel returns a value.
        """
        packed = [self._packed(value) for value in arguments]
        layout = "".join([marks for _, marks, _ in packed])
        key = called, layout, tuple([id(kind) for kind, _, _ in packed])
        if key not in self._entries:
            self._entries[key] = _entry(called, tuple(kind for kind, _, _ in packed), layout, self._compile_ahead)
        if not self._entries[key]:
            raise NotRecordableError(f"{called.__name__} returns a value")
        first = len(self.words)
        for _, _, words in packed:
            self.words.extend(words)
        return self._entries[key], first

    def job(self, called: Kernel, arguments: tuple[Any, ...]) -> Job:
        """Return what has to be compiled for a call.

        Raises:
            NotRecordableError: An argument cannot be packed.
        """
        packed = [self._packed(value) for value in arguments]
        return Job(called, tuple(kind for kind, _, _ in packed), "".join(marks for _, marks, _ in packed))

    def _packed(self, value: Any) -> Packed:
        key = _identity(value)
        if key in self._known:
            return self._known[key]
        kind = self._typed(value)
        words = GIVEN if value is self._worlds else _words(kind, value)
        packed = kind, "".join(mark for mark, _ in words), array("q", [word for _, word in words])
        if key is not None:
            self._known[key] = packed
        return packed

    def _typed(self, value: Any) -> Any:
        """Return Numba's type of an argument, which for arrays takes as long as all the rest unless it is known."""
        if not isinstance(value, np.ndarray):
            return typed(value)
        flags = value.flags
        form = value.dtype, value.ndim, flags.c_contiguous, flags.f_contiguous, flags.writeable
        if form not in self._types:
            self._types[form] = typed(value)
        return self._types[form]


def _identity(value: Any) -> Hashable:
    """Return by what an array, or a tuple of arrays, is known again; None for anything else."""
    if isinstance(value, np.ndarray | Struct):
        return id(value)
    if isinstance(value, tuple):
        parts = [_identity(item) for item in value]
        return None if None in parts else (type(value), *parts)
    return None


def _entry(called: Kernel, types: tuple[Any, ...], layout: str, compile_ahead: Callable[[], None] | None) -> int:
    """Return the address of a packed entry, 0 where the kernel returns a value."""
    if hooks.are_usable():
        try:
            return called.packed.address(types, layout, compile_ahead)
        except NumbaError:
            raise  # in the kernel, which cannot be compiled at all
        except Exception as error:
            hooks.give_up(f"failed with {type(error).__name__}: {error}")
    raise NotRecordableError(f"{called.__name__} has no packed entry")


def _words(kind: Any, value: Any) -> Words:
    try:
        return words_of(kind, value)
    except NotPackableError as error:
        raise NotRecordableError(str(error)) from error


def _enter(context: Any, entry: Any, where: Any, count: Any) -> Any:
    """Make the call whose row of the table is at the address ``entry``, all int64; returns Numba's status."""

    def generate(context: Any, build: Any, signature: Any, arguments: Any) -> Any:
        row, *rest = arguments
        table = build.inttoptr(row, WORD.as_pointer())
        address, packed = (build.load(build.gep(table, [ir.Constant(WORD, k)])) for k in (0, 1))
        entry_type = ir.FunctionType(STATUS, [WORD.as_pointer(), WORD, WORD])
        pointer = build.inttoptr(packed, WORD.as_pointer())
        return build.call(build.inttoptr(address, entry_type.as_pointer()), [pointer, *rest])

    return types.int32(types.int64, types.int64, types.int64), generate


enter: Any = intrinsic(_enter)


@kernel
def make_calls(entries: Ints, worlds: Ints, block: int) -> int:
    """Make all calls ``(n_calls, 2)`` for the worlds ``(n,)``; see ``call_all``."""
    return call_all(entries.ctypes.data, entries.shape[0], worlds.ctypes.data, worlds.shape[0], block)


@kernel
def call_all(entries: int, n_calls: int, worlds: int, total: int, block: int) -> int:
    """Make all calls for one block of worlds after the other.

    Args:
        entries: Address of a table: the addresses of the packed entry and of the packed arguments of each call.
        n_calls: How many calls these are.
        worlds: Where the worlds to treat stand.
        total: How many worlds these are.
        block: Most worlds in a block.

    Returns:
        The number of the call that failed, from 1; 0 if none did.
    """
    for first in range(0, total, block):
        where, count = worlds + 8 * first, min(block, total - first)
        for k in range(n_calls):
            status = enter(entries + 16 * k, where, count)
            if status != OK and status != OK_NONE:
                return k + 1
    return 0
