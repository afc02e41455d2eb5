"""Finds out whether a function that is to be recorded does more than calling kernels.

A recorded step repeats calls of kernels and nothing else. Anything that a method does with NumPy would be lost without
a message. So a step with kinds from outside the package is first recorded while all arrays are read-only: a method that
writes to one raises.
"""

import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.registry import OWN


def place_of_write(run: Callable[[], object], owner: object) -> str:
    """Call a function while all arrays of its owner are read-only; return where it raises and what, or nothing."""
    try:
        with _read_only(_arrays(owner, set())):
            run()
    except Exception as error:  # NumPy's ValueError for a read-only array, or what the method makes of it
        frames = list(traceback.walk_tb(error.__traceback__))
        names = [frame.f_globals.get("__name__", "") for frame, _ in frames]
        outside = [i for i, name in enumerate(names) if name.split(".")[0] not in ("irsim_gym", "numpy")]
        frame, line = frames[outside[-1] if outside else -1]
        return f"{frame.f_code.co_filename}:{line}: {error}"
    return ""


def _arrays(holder: Any, known: set[int]) -> Iterator[NDArray[Any]]:
    """Yield the arrays that an object holds, at any depth."""
    if id(holder) in known:
        return
    known.add(id(holder))
    if isinstance(holder, np.ndarray):
        yield holder
        return
    parts: Any = holder if isinstance(holder, list | tuple) else ()
    if isinstance(holder, Mapping):
        parts = holder.values()
    # Only objects of the package are searched, and no recorded functions (``programs``): they hold their own tables.
    elif type(holder).__module__.startswith(OWN) and not isinstance(holder, type) and not hasattr(holder, "programs"):
        parts = getattr(holder, "__dict__", {}).values()
    for part in parts:
        yield from _arrays(part, known)


@contextmanager
def _read_only(arrays: Iterator[NDArray[Any]]) -> Iterator[None]:
    # A view can be made writable again only after the array that owns its memory.
    owners_first = sorted((array for array in arrays if array.flags.writeable), key=lambda one: one.base is not None)
    try:
        for array in owners_first:
            array.flags.writeable = False
        yield
    finally:
        for array in owners_first:
            array.flags.writeable = True
