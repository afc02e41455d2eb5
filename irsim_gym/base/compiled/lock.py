"""One process compiles a kernel, and others wait for the file that it writes.

A lock is the operating system's, on a file beside that one, so it ends with its process, however that ends. A process
that cannot get a lock goes on without: at worst a kernel is compiled twice.
"""

import errno
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from irsim_gym.base.compiled.trust import open_private
from irsim_gym.base.compiled.watch import compilation

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

PATIENCE_S = 60.0
"""The longest wait for one kernel [s]: the process that compiles it may have been stopped."""
LOOK_S = 0.01
"""Time between two looks [s]."""
# How systems say that another process holds the lock.
TAKEN = (errno.EACCES, errno.EAGAIN)

_held: ContextVar[tuple[Path, ...]] = ContextVar("held", default=())


@contextmanager
def lock(file: Path, *, is_ordered: bool, waits: bool = True) -> Iterator[bool]:
    """Hold the lock of a file of compiled code, if possible. Look for the file again in the body.

    Args:
        file: What will be written.
        is_ordered: Whether a process that holds some locks may wait for this one. It may if all of them belong to
            kernels that call each other in one direction, as those of the package do; otherwise two processes could
            wait for each other.
        waits: Whether to wait for a process that holds it.

    Yields:
        Whether it is held now.
    """
    held = _held.get()
    path = file.with_suffix(".lock")
    # A lock that this thread holds already, further up in the same compilation, is not waited for.
    may_wait = waits and (is_ordered or not held)
    descriptor = None if path in held else _acquire(path, PATIENCE_S if may_wait else 0.0)
    if descriptor is None:
        yield False
        return
    before = _held.set((*held, path))
    try:
        yield True
    finally:
        _held.reset(before)
        _release(path, descriptor)


@contextmanager
def sole(path: Path) -> Iterator[bool]:
    """Hold the lock of a file, and yield True; yield False where another process holds it. Nobody waits.

    Where there are no locks, True.
    """
    descriptor, is_free = None, True
    try:
        while descriptor is None:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
            is_free = _try(descriptor)
            if is_free and not os.fstat(descriptor).st_nlink:  # its holder has just removed it
                os.close(descriptor)
                descriptor = None
    except OSError:
        is_free = True
    try:
        yield is_free
    finally:
        if descriptor is not None and is_free:
            _release(path, descriptor)
        elif descriptor is not None:
            os.close(descriptor)


def _acquire(path: Path, patience: float) -> int | None:
    """Return the descriptor of a locked file; None where there is no lock, or its holder has just done the work."""
    try:
        descriptor = open_private(path)
    except OSError:
        return None
    try:
        taken = _wait(descriptor, patience)
        # A process that has done the work removes the file; one that was killed leaves it.
        if taken and os.fstat(descriptor).st_nlink:
            return descriptor
    except OSError:  # a file system without locks
        pass
    except BaseException:
        os.close(descriptor)
        raise
    os.close(descriptor)
    return None


def _wait(descriptor: int, patience: float) -> bool:
    """Lock an open file; return whether that was possible in time."""
    begun = time.monotonic()
    try:
        while not _try(descriptor):
            if time.monotonic() - begun >= patience:
                return False
            time.sleep(LOOK_S)
            compilation().on_wait(LOOK_S)
    finally:
        compilation().on_wait_end()
    return True


def _try(descriptor: int) -> bool:
    try:
        if sys.platform == "win32":
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in TAKEN:
            return False
        raise
    return True


def _release(path: Path, descriptor: int) -> None:
    """Remove the file, and unlock it: a forked child may hold the descriptor too, so closing is not enough."""
    with suppress(OSError):  # only POSIX removes a file that others have open
        path.unlink()
    with suppress(OSError):
        if sys.platform == "win32":
            msvcrt.locking(descriptor, msvcrt.LK_UNLCK, 1)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_UN)
    os.close(descriptor)
