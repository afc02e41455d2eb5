"""The one decorator for compiled code, and where its results are kept on disk."""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar, overload

import numba
import numpy as np
from numba.core import config as numba_config
from numba.core import event

config: Any = numba_config
PACKAGE = Path(__file__).parent
KEPT_FOLDERS = 4
WITHOUT_KERNELS = {"scenario", "envs", "evaluation", "training", "render", "live", "__init__.py"}

F = TypeVar("F", bound=Callable[..., Any])


@overload
def kernel(function: F, /) -> F: ...
@overload
def kernel(*, contract: bool = False, allocates: bool = False) -> Callable[[F], F]: ...
def kernel(function: Any = None, /, *, contract: bool = False, allocates: bool = False) -> Any:
    """Compile a function: it releases the GIL, divides as NumPy does and is cached on disk.

    With ``NUMBA_DISABLE_JIT=1`` the function stays plain Python, under ``np.errstate``.

    A kernel owns no arrays: it is compiled without reference counts, so that a row of an array costs nothing (with
    them, S1's step takes half as long again), and one that allocates does not compile.

    Args:
        function: The function, when used without brackets.
        contract: Allow fused multiply-add; for float32 ray kernels alone.
        allocates: It makes arrays, or sorts, and is called rarely enough not to mind what that costs.
    """
    if function is None:
        return functools.partial(kernel, contract=contract, allocates=allocates)
    if config.DISABLE_JIT:
        return np.errstate(all="ignore")(function)
    fastmath = {"contract"} if contract else False
    options: Any = {"nogil": True, "error_model": "numpy", "fastmath": fastmath, "_nrt": allocates}
    compiled = numba.njit(**options)(function)
    _keep_on_disk(compiled)
    return Kernel(compiled)


class Kernel:
    """A compiled function: called as usual, from Python or from other kernels, unless its calls are recorded.

    Attributes:
        compiled: Numba's dispatcher; its attributes, such as ``py_func``, are found here too.
    """

    def __init__(self, compiled: Any) -> None:
        functools.update_wrapper(self, compiled.py_func)
        self.compiled = compiled

    def __call__(self, *arguments: Any) -> Any:
        """Run the function, or note the call where ``recording`` is under way in this thread."""
        calls = _calls.get()
        if calls is not None:
            calls.append((self, arguments))
            return None
        return self.compiled(*arguments)

    @property
    def _numba_type_(self) -> Any:
        """What Numba takes this for, within other kernels."""
        return self.compiled._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name == "compiled":  # while it is unpickled
            raise AttributeError(name)
        return getattr(self.compiled, name)

    def __reduce__(self) -> str:
        return str(self.compiled.py_func.__qualname__)


Calls = list[tuple[Kernel, tuple[Any, ...]]]
_calls: ContextVar[Calls | None] = ContextVar("calls", default=None)


@contextmanager
def recording() -> Iterator[Calls]:
    """Note the kernels that are called from Python here, with their arguments, in place of running them."""
    calls: Calls = []
    token = _calls.set(calls)
    try:
        yield calls
    finally:
        _calls.reset(token)


def _keep_on_disk(compiled: Any) -> None:
    """Turn on Numba's cache in a folder of ours; without a writable folder, or without a source file, do without."""
    folder = cache_folder()
    if folder is None:
        return
    given, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        compiled.enable_caching()
    except RuntimeError:  # typed into a console: there is no file whose changes would be seen
        pass
    finally:
        config.CACHE_DIR = given


@functools.cache
def cache_folder() -> Path | None:
    """Return the folder for compiled code: named by a digest of all sources, so it is never stale.

    Numba's own key looks at a kernel's file alone and misses an edited callee in another file.
    The place is ``NUMBA_CACHE_DIR`` if set, else ``__pycache__`` of the package, else the user's cache
    directory, else a temporary one; None when nothing can be written.
    """
    for root in _cache_roots():
        folder = root / f"irsim_gym-{source_digest()}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError:
            continue
        os.utime(folder)
        _prune(root)
        return folder
    return None


def _cache_roots() -> list[Path]:
    user = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    roots = [PACKAGE / "__pycache__", Path(user) / "irsim_gym", Path(tempfile.gettempdir()) / "irsim_gym"]
    return [Path(config.CACHE_DIR), *roots] if config.CACHE_DIR else roots


@functools.cache
def source_digest() -> str:
    """Return a digest of all Python sources that can enter a kernel."""
    digest = hashlib.blake2b(digest_size=8)
    for file in sorted(PACKAGE.rglob("*.py")):
        place = file.relative_to(PACKAGE)
        if place.parts[0] not in WITHOUT_KERNELS and not place.parts[0].startswith("cli"):
            digest.update(place.as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _prune(root: Path) -> None:
    """Remove all but the most recently used folders of earlier sources."""
    folders = sorted(root.glob("irsim_gym-*"), key=_modified, reverse=True)
    for old in folders[KEPT_FOLDERS:]:
        shutil.rmtree(old, ignore_errors=True)


def _modified(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:
        return 0.0


class _CompileNote(event.Listener):
    """Says once, on the screen, that the first use of a kernel takes a while."""

    def __init__(self) -> None:
        self.said = False

    def on_start(self, event: event.Event) -> None:
        if self.said or not event.data["dispatcher"].py_func.__module__.startswith("irsim_gym"):
            return
        self.said = True
        print(
            "irsim_gym: compiling kernels for this machine (half a minute or so, first use only) ...", file=sys.stderr
        )

    def on_end(self, event: event.Event) -> None:
        pass


event.register("numba:compile", _CompileNote())  # type: ignore[no-untyped-call]
