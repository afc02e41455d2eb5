"""The decorator for compiled code, and the recording of calls."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numba
import numpy as np
from numba.core.errors import NumbaError

from irsim_gym.base.compiled.folder import is_cacheable, plain_folder
from irsim_gym.base.compiled.watch import compilation
from irsim_gym.base.kernels import hooks

if TYPE_CHECKING:
    from irsim_gym.base.kernels.packed import PackedEntries

config: Any = numba.config
unliteral: Any = numba.types.unliteral

RESULTS = ("nogil", "error_model", "fastmath")
"""The options that results and threads depend on."""
NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Compile no entry points for Python and for C: they take a third of the time."""

F = TypeVar("F", bound=Callable[..., Any])


@overload
def kernel(function: F, /) -> F: ...
@overload
def kernel(*, contract: bool = False, allocates: bool = False, inlined: bool = False) -> Callable[[F], F]: ...
def kernel(function: Any = None, /, *, contract: bool = False, allocates: bool = False, inlined: bool = False) -> Any:
    """Compile a function: it releases the GIL, divides as NumPy does and is cached on disk.

    With ``NUMBA_DISABLE_JIT=1`` the function stays plain Python, under ``np.errstate``.

    A kernel owns no arrays. It is compiled without reference counts, so that a row of an array costs nothing; with
    them, S1's step takes half as long again. A kernel that allocates, sorts, or assigns a whole row of another array
    (which may raise an error with a message) does not compile.

    Args:
        function: The function, when used without brackets.
        contract: Allow fused multiply-add; for float32 ray kernels alone.
        allocates: Compile with reference counts, for a kernel that makes arrays or sorts, and is called seldom.
        inlined: Inline it into each kernel that calls it, however long it is: an array among the arguments of a call
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

    Numba's dispatchers are made when they are first needed: most kernels are never used in a process.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self._function = function
        self._options = options

    def __call__(self, *arguments: Any) -> Any:
        """Run the function, or note the call where ``record`` is under way in this thread."""
        # A context variable belongs to one thread: others run their kernels while this one records.
        calls = _calls.get()
        if calls is not None:
            calls.append((self, arguments))
            return None
        return self.compiled(*arguments)

    @functools.cached_property
    def compiled(self) -> Any:
        """Numba's dispatcher for calls from Python, which are never recorded; its attributes are the kernel's too."""
        if not hooks.are_usable():
            return self.plain

        def entry() -> tuple[Any, dict[str, Any]]:
            from irsim_gym.base.kernels.passes import EntryCompiler

            return None, {"pipeline_class": EntryCompiler}

        return self._dispatcher("compiled", entry)

    @functools.cached_property
    def packed(self) -> PackedEntries:
        """Entries for calls by address; only where ``hooks.are_usable``."""
        from irsim_gym.base.kernels.packed import PackedEntries

        compilation()
        return PackedEntries(self._function, {**NO_WRAPPERS, **self._options})

    @functools.cached_property
    def inner(self) -> Any:
        """Numba's dispatcher for calls from other kernels; only where ``hooks.are_usable``."""

        def inner() -> tuple[Any, dict[str, Any]]:
            from irsim_gym.base.kernels.inner import InnerCompiler, InnerLibrary

            return InnerLibrary.restore, {**NO_WRAPPERS, "pipeline_class": InnerCompiler}

        return self._dispatcher("inner", inner)

    @functools.cached_property
    def plain(self) -> Any:
        """Numba's dispatcher in its own way, with its own cache."""
        compilation()
        # Numba would take `_nrt` from the kernel that it is compiling now, which may count no references.
        return plain_dispatcher(self._function, {"_nrt": True, **{name: self._options[name] for name in RESULTS}})

    def _dispatcher(self, form: str, hooked: Callable[[], tuple[Any, dict[str, Any]]]) -> Any:
        """Return a dispatcher with hooks.

        Args:
            form: Name of the form.
            hooked: Returns what restores the form from disk, and options; it imports Numba's internals.
        """
        compilation()
        try:
            from irsim_gym.base.compiled.cache import keep_on_disk

            restore, options = hooked()
            given: Any = {**self._options, "no_cfunc_wrapper": True, **options}
            dispatcher: Any = numba.njit(**given)(self._function)
            keep_on_disk(dispatcher, form, restore)
        except Exception as error:
            hooks.give_up(f"failed with {type(error).__name__}: {error}")
            return self.plain
        dispatcher.compile = functools.partial(self._compile, dispatcher, dispatcher.compile)
        return dispatcher

    def _compile(self, dispatcher: Any, compile_hooked: Callable[[Any], Any], signature: Any) -> Any:
        """Compile or load the code for a signature; in Numba's plain way where the hooks fail."""
        # Numba compiles a kernel once more for each number that a caller writes out.
        signature = tuple(unliteral(one) for one in signature)
        if hooks.are_usable():
            try:
                return compile_hooked(signature)
            except NumbaError:
                raise  # the kernel is wrong, not a hook
            except Exception as error:
                with hooks.without(error):
                    self.plain.compile(signature)
        entry = self.plain.compile(signature)
        # The hooked dispatcher takes over the plain code, so that later calls with these types find it at once.
        dispatcher.add_overload(self.plain.overloads[signature])
        return entry

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes this for, within other kernels."""
        return (self.inner if hooks.are_usable() else self.plain)._numba_type_

    def __getattr__(self, name: str) -> Any:
        # Numba's attributes have public names. While a kernel is unpickled, nothing is there yet that could answer.
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.compiled, name)

    def __reduce__(self) -> str:
        return str(self._function.__qualname__)


def plain_dispatcher(function: Any, options: dict[str, Any]) -> Any:
    """Return ``numba.njit(cache=True)`` of a function; the folder of the cache follows the sources of the package.

    Where the cache fails, as on a full disk, the function is compiled without one.
    """
    folder = plain_folder() if is_cacheable(function) else None
    # Numba reads the folder of its cache from its configuration when the dispatcher is made, and only then.
    usual = config.CACHE_DIR
    try:
        config.CACHE_DIR = str(folder or "")
        dispatcher: Any = numba.njit(cache=folder is not None, **options)(function)
    finally:
        config.CACHE_DIR = usual
    compile_cached = dispatcher.compile

    def compiled(signature: Any) -> Any:
        try:
            return compile_cached(signature)
        except NumbaError:
            raise
        except Exception:
            # The cache could not be written or read; the second attempt shows errors of the compiler itself.
            dispatcher._cache.disable()
            return compile_cached(signature)

    dispatcher.compile = compiled
    return dispatcher


Calls = list[tuple[Kernel, tuple[Any, ...]]]
_calls: ContextVar[Calls | None] = ContextVar("calls", default=None)


def record(function: Callable[..., None], *arguments: Any) -> Calls:
    """Run a function, and note the kernels that it calls, with their arguments, instead of running them.

    This is no context manager: an interrupt between its start and its body would leave every kernel of this thread
    recording for good. Recordings nest.
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
