"""Whether kinds from outside keep what they promise with ``only_kernels``.

A recorded step repeats calls of kernels and nothing else: what a method does by NumPy would be lost, in silence. So a
step is first recorded while all arrays are read-only: a method that writes one raises. Then the first calls take the
plain path and are recorded again each time: a number or an array that changes between them shows.
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
"""How often a function is recorded again."""

CURE = "steps take the plain path; write it as a kernel, or leave only_kernels out"


class Promise:
    """What kinds from outside promise, for all functions of a simulation that are recorded.

    Args:
        forget: Lets go of everything that was recorded.

    Attributes:
        kinds: Kinds from outside that promise; those of the package are believed.
        is_broken: It was found that one of them does more than to call kernels.
        is_checking: Arrays are read-only at the moment, so nothing may be packed for later.
    """

    def __init__(self, forget: Callable[[], None]) -> None:
        self.kinds: list[type[Any]] = []
        self.is_broken = False
        self.is_checking = False
        self._forget = forget

    def among(self, kinds: Sequence[type[Any]]) -> Promise | None:
        """Return the promise if any of some kinds is from outside, and note those that are; else None."""
        foreign = [kind for kind in kinds if is_foreign(kind)]
        self.kinds += [kind for kind in foreign if kind not in self.kinds]
        return self if foreign else None

    def check(self, run: Callable[[], object], owner: object) -> None:
        """Run what records a function while no array of its owner, at any depth, can be written."""
        if self.is_broken:
            return
        self.is_checking = True
        try:
            with _read_only(list(_arrays(owner))):
                run()
        except Exception as error:  # whatever NumPy says
            self.break_off(f"{_place(error)}: {error}")
        finally:
            self.is_checking = False

    def break_off(self, why: str) -> None:
        """Note, and warn once, that the promise is broken."""
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
        elif not isinstance(item, type) and hasattr(item, "__dict__") and not hasattr(item, "programs"):
            waiting.extend(vars(item).values() if type(item).__module__.startswith("irsim_gym.") else ())


@contextmanager
def _read_only(arrays: Sequence[NDArray[Any]]) -> Iterator[None]:
    owners_first = sorted((array for array in arrays if array.flags.writeable), key=lambda one: one.base is not None)
    try:
        for array in owners_first:
            array.flags.writeable = False
        yield
    finally:
        for array in owners_first:
            array.flags.writeable = True


def _place(error: BaseException) -> str:
    """Return file and line where an error comes from, in code from outside if there is any."""
    frames = list(traceback.walk_tb(error.__traceback__))
    names = [frame.f_globals.get("__name__", "") for frame, _ in frames]
    outside = [i for i, name in enumerate(names) if name.split(".")[0] not in ("irsim_gym", "numpy")]
    frame, line = frames[outside[-1] if outside else -1]
    return f"{frame.f_code.co_filename}:{line}"
