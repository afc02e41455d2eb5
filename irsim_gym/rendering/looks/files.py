"""Atomic writing of files."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from irsim_gym.base.outside_files import writing


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path in the same folder, with the same suffix; at the end, rename it to the file.

    After an exception, the temporary file is removed. Missing folders are created.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        with writing(path):
            yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
