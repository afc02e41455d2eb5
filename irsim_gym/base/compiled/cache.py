"""Compiled code on disk: never stale, shared by processes, and never a reason to fail."""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack, suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import compiler, serialize
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime.nrt import rtsys

from irsim_gym.base.compiled.folder import PACKAGE, cache_folder, is_cacheable, remove_unused
from irsim_gym.base.compiled.key import function_key, type_key
from irsim_gym.base.compiled.lock import lock
from irsim_gym.base.compiled.trust import read_trusted, write_private

CompileResult: Any = compiler.CompileResult
# Numba's settings that change the machine code, and so the name of a file.
SETTINGS = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")


def keep_on_disk(dispatcher: Any, form: str, restore: Callable[[Any, Any], Any] | None = None) -> None:
    """Give a dispatcher this module's cache, unless nothing can be kept.

    Args:
        dispatcher: Numba's.
        form: What distinguishes its code from that of other dispatchers with the same function.
        restore: Makes Numba's library from what is on disk, given Numba's code generator; None to let Numba do so.
    """
    options, files = dispatcher.targetoptions, files_of(dispatcher.py_func, dispatcher.targetoptions, form)
    if files is not None:
        cache = dispatcher._cache = KernelCache(files, options["_nrt"], restore)
        dispatcher.compile = cache.in_turn(dispatcher.compile)


def files_of(function: Any, options: Mapping[str, Any], form: str) -> Files | None:
    """Return a function's files; None without a folder, or if its source file alone does not define it."""
    if is_cacheable(function) and cache_folder() is not None:
        return Files(function, f"{form} {sorted(options.items(), key=str)}")
    return None


class Files:
    """What is on disk of a function: one file for each signature and processor, replaced as a whole, with a checksum.

    A file that cannot be read, is damaged, or may have been written by another user counts as missing. Failing to write
    one is no error.

    Attributes:
        is_own: Whether the function is in the package.
    """

    def __init__(self, function: Any, options: str) -> None:
        self.is_own = Path(function.__code__.co_filename).is_relative_to(PACKAGE)
        self._name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._key = function_key(function)
        self._options = options

    def file(self, signature: Any, codegen: Any) -> Path:
        """Return the file for a signature, on this processor and with these settings."""
        settings = [str(getattr(numba.config, name, None)) for name in SETTINGS]
        key = [*map(type_key, signature), *map(str, codegen.magic_tuple()), *settings, self._options, self._key]
        digest = hashlib.blake2b("\n".join(key).encode(), digest_size=10).hexdigest()
        return (cache_folder() or Path()) / f"{self._name}-{digest}.nbc"

    def lock(self, file: Path, *, waits: bool = True) -> AbstractContextManager[bool]:
        """Return the lock of a file that does not exist yet: its holder compiles, and other processes wait."""
        return lock(file, is_ordered=self.is_own, waits=waits)

    @staticmethod
    def read(file: Path) -> bytes | None:
        """Return the content of a file, None if it is not there."""
        content = read_trusted(file)
        if content:
            with suppress(OSError):  # it is still in use
                os.utime(file)
        return content[16:] if content and content[:16] == _checksum(content[16:]) else None

    @staticmethod
    def write(file: Path, content: bytes) -> None:
        """Write a file, if there is room."""
        # Written under another name and renamed, so that no process ever reads half a file.
        passing = file.with_suffix(f".{os.getpid()}")
        try:
            write_private(passing, _checksum(content) + content)
            passing.replace(file)
            remove_unused(file.parent)
        except OSError:
            passing.unlink(missing_ok=True)


class Restoring:
    """Numba's target, with another way to make a library from what is on disk."""

    def __init__(self, target: Any, restore: Callable[[Any, Any], Any]) -> None:
        self._target = target
        self._restore = restore

    def codegen(self) -> Restoring:
        """Return what makes libraries: this object."""
        return self

    def unserialize_library(self, serialized: Any) -> Any:
        """Make the library."""
        return self._restore(self._target.codegen(), serialized)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._target, name)


class KernelCache:
    """A cache with Numba's interface. Numba's own mixes up signatures that two processes save at the same time.

    Files that do not fit are ignored, and the code is compiled anew.
    """

    def __init__(self, files: Files, allocates: bool, restore: Callable[[Any, Any], Any] | None) -> None:
        self._files = files
        self._allocates = allocates
        self._restore = restore
        self._turns: list[ExitStack] = []

    def in_turn(self, make: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Return Numba's function that loads or compiles, so that it releases the lock of the file at its end."""

        def maker(signature: Any) -> Any:
            # ``load_overload`` takes the file's lock, and ``make`` compiles if it found nothing: both within this call.
            with global_compiler_lock, ExitStack() as turn:
                self._turns.append(turn)
                turn.callback(self._turns.pop)
                return make(signature)

        return maker

    @property
    def cache_path(self) -> str:
        """The folder, '' if there is none."""
        return str(cache_folder() or "")

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the compiled code for some types of arguments; None if this process has to compile it.

        Numba's own cache prepares the compiler first, which takes a third of a warm start, as it imports SciPy where
        that is installed. Kernels of the package need at most its memory management; those of users may have types
        from extensions.
        """
        if not self._files.is_own:
            target.refresh()
        elif self._allocates:
            rtsys.initialize(target)
        file = self._files.file(signature, target.codegen())
        overload = self._restored(file, signature, target)
        if overload is None and self._turns:
            self._turns[-1].enter_context(self._files.lock(file))
            overload = self._restored(file, signature, target)  # another process may have written it by now
        return overload

    def _restored(self, file: Path, signature: Any, target: Any) -> Any:
        content = self._files.read(file)
        if content is None:
            return None
        try:
            parts = pickle.loads(content)
            compiled = CompileResult._rebuild(Restoring(target, self._restore) if self._restore else target, *parts)
        except (OSError, pickle.UnpicklingError, ImportError, AttributeError):
            return None
        # A guard against equal digests of different types.
        fits = tuple(compiled.signature.args) == tuple(signature)
        return compiled._replace(target_context=target) if fits else None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Write compiled code, if it can be kept."""
        if not compiled.library.has_dynamic_globals:
            content: bytes = serialize.dumps(compiled._reduce())  # type: ignore[no-untyped-call]
            self._files.write(self._files.file(signature, compiled.codegen), content)

    def enable(self) -> None:
        """Part of the interface: this cache is always on."""

    def disable(self) -> None:
        """Part of the interface: this cache is always on."""

    def flush(self) -> None:
        """Part of the interface: files are never stale."""


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=16).digest()
