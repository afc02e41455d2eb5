"""The folder of compiled code: where it lies, and what is removed from it."""

import functools
import hashlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np

from irsim_gym.base.compiled.trust import make_private_folder

config: Any = numba.config
PACKAGE = Path(__file__).parents[2]
GENERATORS = ("base/kernels/*.py", "base/compiled/*.py")
"""Sources that say how kernels are compiled, or generate code: each change of them compiles all anew."""
KEPT_FOLDERS = 4
KEPT_S = 3600.0
"""Folders of other versions stay that long [s] after their last use, the newest ``KEPT_FOLDERS`` for good."""
UNUSED_S = 30 * 86400.0
"""Files that nobody has read for that long [s] are removed."""


@functools.cache
def cache_folder() -> Path | None:
    """Return the folder for compiled code, named by a digest of the compiler's versions.

    The place is ``NUMBA_CACHE_DIR`` if set, else ``__pycache__`` of the package, else the user's cache
    directory, else a temporary one; None when nothing can be written. The folder is made for its owner alone, and one
    that somebody else may write is passed over with a warning, because what is read from it is run.
    """
    for root in _cache_roots():
        folder = root / f"irsim_gym-{compiler_digest()}"
        try:
            if root == _temporary_root() and not make_private_folder(root):
                continue
            if not make_private_folder(folder):
                continue
            with tempfile.TemporaryFile(dir=folder):
                pass
            # The time of the last use, by which ``_prune`` chooses.
            os.utime(folder)
        except OSError:
            continue
        _prune(root)
        return folder
    return None


@functools.cache
def plain_folder() -> Path | None:
    """Return the folder for what Numba caches by itself, None when nothing can be written.

    Numba's own key does not cover the kernels that a kernel calls in other files, so all sources name the folder.
    """
    above = cache_folder()
    folder = above and above / f"plain-{_digest(PACKAGE.rglob('*.py'))}"
    return folder if folder and make_private_folder(folder) else None


def is_cacheable(function: Any) -> bool:
    """Return whether a source file alone says what the function is."""
    return function.__closure__ is None and Path(function.__code__.co_filename).is_file()


def _cache_roots() -> list[Path]:
    try:
        user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # there is no home directory
        user = _temporary_root()
    roots = [PACKAGE / "__pycache__", user / "irsim_gym", _temporary_root()]
    configured: str = config.CACHE_DIR
    return [Path(configured), *roots] if configured else roots


def _temporary_root() -> Path:
    return Path(tempfile.gettempdir()) / f"irsim_gym-{os.getuid() if hasattr(os, 'getuid') else 'user'}"


@functools.cache
def compiler_digest() -> str:
    """Return a digest of the versions of the compiler, and of the sources that generate code."""
    return _digest(file for pattern in GENERATORS for file in PACKAGE.glob(pattern))


def _digest(files: Iterable[Path]) -> str:
    digest = hashlib.blake2b(digest_size=8)
    versions = sys.implementation.cache_tag, numba.__version__, llvmlite.__version__, np.__version__
    digest.update(repr(versions).encode())
    for file in sorted(files):
        digest.update(file.relative_to(PACKAGE).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _prune(root: Path) -> None:
    """Remove the folders of other versions that nobody used lately."""
    folders = sorted(root.glob("irsim_gym-*"), key=_modified, reverse=True)
    for old in folders[KEPT_FOLDERS:]:
        if _modified(old) < time.time() - KEPT_S:
            shutil.rmtree(old, ignore_errors=True)


@functools.cache
def remove_unused(folder: Path) -> None:
    """Remove files that nobody has read lately, once in each process: their kernels have changed since."""
    for file in folder.glob("*.nbc"):
        if _modified(file) < time.time() - UNUSED_S:
            file.unlink(missing_ok=True)


def _modified(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
