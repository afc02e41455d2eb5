"""Whether compiled code on disk may be run: only where no other user can have written it."""

import os
import stat
import warnings
from pathlib import Path

from irsim_gym.base.errors import UntrustedCodeWarning

PRIVATE_FOLDER = 0o700
PRIVATE_FILE = 0o600
HAS_OWNERS = hasattr(os, "getuid")
"""Whether the system knows owners as POSIX does; elsewhere the user's own folders are private by themselves."""


def make_private_folder(folder: Path) -> bool:
    """Make a folder for its owner alone, unless it exists; return whether it may be used.

    Raises:
        OSError: It cannot be made.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(PRIVATE_FOLDER, exist_ok=True)
    return may_be_run(folder, os.lstat(folder))


def read_trusted(file: Path) -> bytes | None:
    """Return the content of a file, None if it is not there or may not be run."""
    try:
        with file.open("rb") as opened:
            return opened.read() if may_be_run(file, os.fstat(opened.fileno())) else None
    except OSError:
        return None


def write_private(file: Path, content: bytes) -> None:
    """Write a new file for its owner alone.

    Raises:
        OSError: It cannot be written, or exists.
    """
    with open(file, "xb", opener=lambda path, flags: os.open(path, flags, PRIVATE_FILE)) as opened:
        opened.write(content)


def open_private(file: Path) -> int:
    """Open a file for its owner alone, make it if need be, and return its descriptor; nothing in it is ever read.

    Raises:
        OSError: It cannot be made, is a link, or may be written by others.
    """
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), PRIVATE_FILE)
    if not may_be_run(file, os.fstat(descriptor)):
        os.close(descriptor)
        raise PermissionError(file)
    return descriptor


def may_be_run(path: Path, status: os.stat_result) -> bool:
    """Return whether a file or folder belongs to this user and nobody else may write it; warn if not."""
    if not HAS_OWNERS:
        return True
    if stat.S_ISLNK(status.st_mode):
        reason = "is a link"
    elif status.st_uid != os.getuid():
        reason = f"belongs to another user (uid {status.st_uid})"
    elif status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        reason = f"may be written by others (mode {stat.S_IMODE(status.st_mode):04o})"
    else:
        return True
    warnings.warn(
        f"{path} {reason}, so the compiled code there is not run: remove it, or set NUMBA_CACHE_DIR to a folder of "
        "your own",
        UntrustedCodeWarning,
        stacklevel=2,
    )
    return False
