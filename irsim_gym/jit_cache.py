"""Compiled code on disk: never stale, shared by processes, and never a reason to fail."""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import compiler, serialize
from numba.core import config as numba_config
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime.nrt import rtsys

from irsim_gym.jit_lock import lock
from irsim_gym.jit_trust import make_private_folder, read_trusted, write_private

config: Any = numba_config
CompileResult: Any = compiler.CompileResult
PACKAGE = Path(__file__).parent
KEPT_FOLDERS = 4
KEPT_S = 3600.0
"""Folders of other sources stay that long [s] after their last use, the newest ``KEPT_FOLDERS`` for good."""
WITHOUT_KERNELS = {"scenario", "envs", "evaluation", "training", "render", "live", "__init__.py"} | {
    "jit_lock.py",
    "jit_trust.py",
    "jit_watch.py",
}
SETTINGS = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")


def keep_on_disk(dispatcher: Any, form: str, restore: Callable[[Any, Any], Any] | None = None) -> None:
    """Give a dispatcher a cache of ours, unless nothing can be kept.

    Args:
        dispatcher: Numba's.
        form: What distinguishes its code from that of other dispatchers with the same function.
        restore: Makes Numba's library from what was kept of it, given Numba's machine; None to let Numba do so.
    """
    options, files = dispatcher.targetoptions, files_of(dispatcher.py_func, dispatcher.targetoptions, form)
    if files is not None:
        cache = dispatcher._cache = KernelCache(files, options["_nrt"], restore)
        dispatcher.compile = cache.in_turn(dispatcher.compile)


def files_of(function: Any, options: Mapping[str, Any], form: str) -> Files | None:
    """Return a function's files; None without a folder, or without a source file whose changes would be seen."""
    if function.__closure__ is None and Path(function.__code__.co_filename).is_file() and cache_folder() is not None:
        return Files(function, f"{form} {sorted(options.items(), key=str)}")
    return None


class Files:
    """What is on disk of a function: one file for each signature and processor, replaced as a whole, with a checksum.

    A file that cannot be read, is damaged, or may have been written by somebody else is not there; one that cannot be
    written is done without.

    Attributes:
        is_own: Whether the function is in the package.
    """

    def __init__(self, function: Any, options: str) -> None:
        self.is_own = _is_own(function)
        self._name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._key = "" if self.is_own else _fingerprint(function, set())
        self._options = options

    def file(self, signature: Any, codegen: Any) -> Path:
        """Return the file for a signature, on this processor and with these settings."""
        settings = [str(getattr(config, name, None)) for name in SETTINGS]
        key = [*map(str, signature), *map(str, codegen.magic_tuple()), *settings, self._options, self._key]
        digest = hashlib.blake2b("\n".join(key).encode(), digest_size=10).hexdigest()
        return (cache_folder() or Path()) / f"{self._name}-{digest}.nbc"

    def lock(self, file: Path) -> AbstractContextManager[None]:
        """Return the lock of a file that is not there: who holds it compiles, and others wait."""
        return lock(file, is_ordered=self.is_own)

    @staticmethod
    def read(file: Path) -> bytes | None:
        """Return the content of a file, None if it is not there."""
        content = read_trusted(file)
        return content[16:] if content and content[:16] == _checksum(content[16:]) else None

    @staticmethod
    def write(file: Path, content: bytes) -> None:
        """Write a file, if there is room."""
        passing = file.with_suffix(f".{os.getpid()}")
        try:
            write_private(passing, _checksum(content) + content)
            passing.replace(file)
        except OSError:
            passing.unlink(missing_ok=True)


class Restoring:
    """Numba's target while compiled code is put together: the same, but for the kind of library."""

    def __init__(self, target: Any, restore: Callable[[Any, Any], Any]) -> None:
        self._target = target
        self._restore = restore

    def codegen(self) -> Restoring:
        """Return what makes a library from what was kept of it."""
        return self

    def unserialize_library(self, kept: Any) -> Any:
        """Make the library."""
        return self._restore(self._target.codegen(), kept)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._target, name)


class KernelCache:
    """Numba's interface of a cache, in place of its own, whose index mixes up signatures saved at the same time.

    What does not fit is compiled anew.
    """

    def __init__(self, files: Files, allocates: bool, restore: Callable[[Any, Any], Any] | None) -> None:
        self._files = files
        self._allocates = allocates
        self._restore = restore
        self._turns: list[ExitStack] = []

    def in_turn(self, make: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Return Numba's function that loads or compiles, which gives back the lock of a file at its end."""

        def made(signature: Any) -> Any:
            with global_compiler_lock, ExitStack() as turn:
                self._turns.append(turn)
                turn.callback(self._turns.pop)
                return make(signature)

        return made

    @property
    def cache_path(self) -> str:
        """The folder, '' if there is none."""
        return str(cache_folder() or "")

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the compiled code for some types of arguments, None if it has to be compiled, by this process.

        Numba would prepare to compile in any case, which takes a third of a warm start: with SciPy installed, it
        imports that. Kernels of the package need at most memory; others may have types that come with extensions.
        """
        if not self._files.is_own:
            target.refresh()
        elif self._allocates:
            rtsys.initialize(target)
        file = self._files.file(signature, target.codegen())
        found = self._restored(file, signature, target)
        if found is None and self._turns:
            self._turns[-1].enter_context(self._files.lock(file))
            found = self._restored(file, signature, target)  # another process may have written it by now
        return found

    def _restored(self, file: Path, signature: Any, target: Any) -> Any:
        content = self._files.read(file)
        if content is None:
            return None
        try:
            kept = pickle.loads(content)
            compiled = CompileResult._rebuild(Restoring(target, self._restore) if self._restore else target, *kept)
        except (OSError, pickle.UnpicklingError, ImportError, AttributeError):
            return None
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


def _is_own(function: Any) -> bool:
    return Path(function.__code__.co_filename).is_relative_to(PACKAGE)


def _fingerprint(function: Any, seen: set[int]) -> str:
    """Return what a kernel outside of the package is made of: its file, the values it reads, the kernels it calls."""
    if id(function) in seen or _is_own(function):
        return ""
    seen.add(id(function))
    code: CodeType = function.__code__
    parts = [_source(code.co_filename), str(code.co_firstlineno)]
    for name in code.co_names:
        value = function.__globals__.get(name)
        called = getattr(value, "__wrapped__", value)
        if isinstance(called, FunctionType):
            parts.append(_fingerprint(called, seen))
        elif isinstance(value, np.ndarray):
            parts.append(hashlib.blake2b(value.tobytes()).hexdigest())
        elif isinstance(value, ModuleType):
            parts.append(_source(getattr(value, "__file__", None) or ""))
        else:
            parts.append(repr(value))
    return "\n".join(parts)


def _source(file: str) -> str:
    return hashlib.blake2b(Path(file).read_bytes()).hexdigest() if file.endswith(".py") else file


@functools.cache
def cache_folder() -> Path | None:
    """Return the folder for compiled code: named by a digest of all sources, so it is never stale.

    The place is ``NUMBA_CACHE_DIR`` if set, else ``__pycache__`` of the package, else the user's cache
    directory, else a temporary one; None when nothing can be written. The folder is made for its owner alone, and one
    that somebody else may write is passed over with a warning, because what is read from it is run.
    """
    for root in _cache_roots():
        folder = root / f"irsim_gym-{source_digest()}"
        try:
            if root == _temporary_root() and not make_private_folder(root):
                continue
            if not make_private_folder(folder):
                continue
            with tempfile.TemporaryFile(dir=folder):
                pass
            os.utime(folder)
        except OSError:
            continue
        _prune(root)
        return folder
    return None


def _cache_roots() -> list[Path]:
    try:
        user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # nobody's home
        user = _temporary_root()
    roots = [PACKAGE / "__pycache__", user / "irsim_gym", _temporary_root()]
    return [Path(config.CACHE_DIR), *roots] if config.CACHE_DIR else roots


def _temporary_root() -> Path:
    return Path(tempfile.gettempdir()) / f"irsim_gym-{os.getuid() if hasattr(os, 'getuid') else 'user'}"


@functools.cache
def source_digest() -> str:
    """Return a digest of all Python sources that can enter a kernel, and of the compiler's versions."""
    digest = hashlib.blake2b(digest_size=8)
    versions = sys.implementation.cache_tag, numba.__version__, llvmlite.__version__, np.__version__
    digest.update(repr(versions).encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        place = file.relative_to(PACKAGE)
        if place.parts[0] not in WITHOUT_KERNELS and not place.parts[0].startswith("cli"):
            digest.update(place.as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _prune(root: Path) -> None:
    """Remove the folders of other sources that nobody used lately."""
    folders = sorted(root.glob("irsim_gym-*"), key=_modified, reverse=True)
    for old in folders[KEPT_FOLDERS:]:
        if _modified(old) < time.time() - KEPT_S:
            shutil.rmtree(old, ignore_errors=True)


def _modified(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:
        return 0.0
