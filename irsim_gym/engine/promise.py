"""Checks that kinds from outside the package keep the promise of ``only_kernels``.

A recorded step repeats calls of kernels and nothing else. Anything that a method does with NumPy would be lost without
a message. So a step is first recorded while all arrays are read-only: a method that writes to one raises. The first
calls then take the plain path and are recorded each time: a number or an array that changes between them is noticed.
"""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.contract import is_foreign, place_of

CALLS = 20
"""Number of calls in which a function is recorded again."""

CURE = "steps take the plain path; write it as a kernel, or leave only_kernels out"


class Promise:
    """The promises of kinds from outside the package, for all recorded functions of a simulation.

    Args:
        forget: Called to discard everything that was recorded.

    Attributes:
        kinds: The kinds from outside that promise. Kinds of the package are not checked.
        is_broken: Whether one of them was found to do more than calling kernels.
        is_checking: Whether arrays are read-only now, so that nothing may be packed for later.
    """

    def __init__(self, forget: Callable[[], None]) -> None:
        self.kinds: list[type[Any]] = []
        self.is_broken = False
        self.is_checking = False
        self._forget = forget

    def among(self, kinds: Sequence[type[Any]]) -> Promise | None:
        """Return the promise if some kinds are from outside the package, and note these; else None."""
        foreign = [kind for kind in kinds if is_foreign(kind)]
        self.kinds += [kind for kind in foreign if kind not in self.kinds]
        return self if foreign else None

    def check(self, run: Callable[[], object], owner: object) -> None:
        """Call the function that records, while all arrays of its owner are read-only."""
        if self.is_broken:
            return
        self.is_checking = True
        try:
            with _read_only(list(_arrays(owner))):
                run()
        except Exception as error:  # NumPy's ValueError for a read-only array, or what the method makes of it
            self.break_off(f"{_place(error)}: {error}")
        finally:
            self.is_checking = False

    def break_off(self, why: str) -> None:
        """Note that the promise is broken, and warn once."""
        if not self.is_broken:
            self.is_broken = True
            kinds = ", ".join(f"{kind.__qualname__}{place_of(kind)}" for kind in self.kinds)
            warnings.warn(f"only_kernels is promised by {kinds}, but {why}; {CURE}", RuntimeWarning, stacklevel=2)
        self._forget()


def _arrays(owner: object) -> Iterator[NDArray[Any]]:
    """Yield the arrays that an object holds, at any depth."""
    waiting, known = [owner], set()
    while waiting:
        item = waiting.pop()
        if id(item) in known:
            continue
        known.add(id(item))
        if isinstance(item, np.ndarray):
            yield item
        elif isinstance(item, Mapping):
            waiting.extend(item.values())
        elif isinstance(item, list | tuple):
            waiting.extend(item)
        # Only objects of the package are searched, and no recorded functions (``programs``): they hold their own
        # tables.
        elif not isinstance(item, type) and hasattr(item, "__dict__") and not hasattr(item, "programs"):
            waiting.extend(vars(item).values() if type(item).__module__.startswith("irsim_gym.") else ())


@contextmanager
def _read_only(arrays: Sequence[NDArray[Any]]) -> Iterator[None]:
    # A view can be made writable again only after the array that owns its memory.
    owners_first = sorted((array for array in arrays if array.flags.writeable), key=lambda one: one.base is not None)
    try:
        for array in owners_first:
            array.flags.writeable = False
        yield
    finally:
        for array in owners_first:
            array.flags.writeable = True


def _place(error: BaseException) -> str:
    """Return file and line of an error, in code from outside the package if there is any."""
    frames = list(traceback.walk_tb(error.__traceback__))
    names = [frame.f_globals.get("__name__", "") for frame, _ in frames]
    outside = [i for i, name in enumerate(names) if name.split(".")[0] not in ("irsim_gym", "numpy")]
    frame, line = frames[outside[-1] if outside else -1]
    return f"{frame.f_code.co_filename}:{line}"
