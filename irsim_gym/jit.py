"""The one decorator for compiled code."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, TypeVar, overload

import numba
import numpy as np
from numba.core import config as numba_config

from irsim_gym.jit_cache import keep_on_disk
from irsim_gym.jit_doors import Doors
from irsim_gym.jit_inner import InnerCompiler, InnerLibrary
from irsim_gym.jit_passes import EntryCompiler
from irsim_gym.jit_watch import compilation

config: Any = numba_config

ONE_WAY = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""No entries from Python and from C, which are a third of the work of compiling."""

F = TypeVar("F", bound=Callable[..., Any])


@overload
def kernel(function: F, /) -> F: ...
@overload
def kernel(*, contract: bool = False, allocates: bool = False, inlined: bool = False) -> Callable[[F], F]: ...
def kernel(function: Any = None, /, *, contract: bool = False, allocates: bool = False, inlined: bool = False) -> Any:
    """Compile a function: it releases the GIL, divides as NumPy does and is cached on disk.

    With ``NUMBA_DISABLE_JIT=1`` the function stays plain Python, under ``np.errstate``.

    A kernel owns no arrays: it is compiled without reference counts, so that a row of an array costs nothing (with
    them, S1's step takes half as long again), and one that allocates, sorts, or assigns a whole row of another array,
    which could fail with a message, does not compile.

    Args:
        function: The function, when used without brackets.
        contract: Allow fused multiply-add; for float32 ray kernels alone.
        allocates: It makes arrays, or sorts, and is called rarely enough not to mind what that costs.
        inlined: Become a part of each kernel that calls it, however long it is: an array among the arguments of a call
            is seven words on the stack.
    """
    if function is None:
        return functools.partial(kernel, contract=contract, allocates=allocates, inlined=inlined)
    if config.DISABLE_JIT:
        plain = np.errstate(all="ignore")(function)
        plain.compiled = plain
        return plain
    fastmath = {"contract"} if contract else False
    options = {"nogil": True, "error_model": "numpy", "fastmath": fastmath, "_nrt": allocates, "forceinline": inlined}
    return Kernel(function, options)


class Kernel:
    """A compiled function: called as usual, from Python or from other kernels, unless its calls are recorded.

    Numba's dispatchers are made when they are asked for: most kernels are never needed in a process.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self._function = function
        self._options = options

    def __call__(self, *arguments: Any) -> Any:
        """Run the function, or note the call where ``record`` is under way in this thread."""
        calls = _calls.get()
        if calls is not None:
            calls.append((self, arguments))
            return None
        return self.compiled(*arguments)

    @functools.cached_property
    def compiled(self) -> Any:
        """Numba's dispatcher for calls from Python, which are never recorded; its attributes are the kernel's too."""
        return self._dispatcher("compiled", pipeline_class=EntryCompiler)

    @functools.cached_property
    def doors(self) -> Doors:
        """Entries for calls by address."""
        compilation()
        return Doors(self._function, {**ONE_WAY, **self._options})

    @functools.cached_property
    def inner(self) -> Any:
        """Numba's dispatcher for calls from other kernels."""
        return self._dispatcher("inner", **ONE_WAY, pipeline_class=InnerCompiler)

    def _dispatcher(self, form: str, **options: Any) -> Any:
        compilation()
        given: Any = {**self._options, "no_cfunc_wrapper": True, **options}
        dispatcher = numba.njit(**given)(self._function)
        keep_on_disk(dispatcher, form, InnerLibrary.restore if form == "inner" else None)
        return dispatcher

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes this for, within other kernels."""
        return self.inner._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # while it is unpickled
            raise AttributeError(name)
        return getattr(self.compiled, name)

    def __reduce__(self) -> str:
        return str(self._function.__qualname__)


Calls = list[tuple[Kernel, tuple[Any, ...]]]
_calls: ContextVar[Calls | None] = ContextVar("calls", default=None)


def record(function: Callable[..., None], *arguments: Any) -> Calls:
    """Run a function, and note the kernels that it calls, with their arguments, in place of running them.

    It is no context manager: an interrupt between the beginning of one and its body would leave every kernel of this
    thread dead. One may be under way within another one.
    """
    calls: Calls = []
    before = _calls.get()
    try:
        _calls.set(calls)
        function(*arguments)
    finally:
        _calls.set(before)
    return calls


def is_recording() -> bool:
    """Return whether ``record`` is under way in this thread."""
    return _calls.get() is not None
