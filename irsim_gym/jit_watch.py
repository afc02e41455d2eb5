"""What goes on around a compilation: a word on the screen where it lasts, and no search for garbage meanwhile."""

from __future__ import annotations

import functools
import gc
import sys
import time
from typing import Any

from numba.core import event

PATIENCE_S = 1.0
"""Seconds of compiling before anything is said."""
NOTE = (
    "irsim_gym: compiling kernels for this machine, some 10 s for a new kind of scenario, first use only "
    "(`irsim-gym warmup` does it beforehand)"
)


class Watch(event.Listener):
    """Follows the compilations of this process; they nest, and Numba lets one thread compile at a time.

    Attributes:
        compiled: How many kernels have been compiled.
        spent: How long that took [s].
        said: Nothing more is to be said.
    """

    def __init__(self) -> None:
        self.compiled = 0
        self.spent = 0.0
        self.said = False
        self._depth = 0
        self._begun = 0.0
        self._collects = False

    def on_start(self, event: event.Event) -> None:
        """Pause the garbage collector, which finds next to nothing and takes a tenth of the time; say what goes on."""
        self._depth += 1
        if self._depth == 1:
            self._begun = time.perf_counter()
            self._collects = gc.isenabled()
            gc.disable()
        self._say(event.data["dispatcher"], self.spent + time.perf_counter() - self._begun)

    def on_end(self, event: event.Event) -> None:
        """Let the collector work again."""
        self._depth -= 1
        self.compiled += 1
        if self._depth == 0:
            self.spent += time.perf_counter() - self._begun
            if self._collects:
                gc.enable()

    def _say(self, dispatcher: Any, spent: float) -> None:
        """Say once, as a line that stays, that it takes a while: when a while has gone, and there is more to do."""
        if spent > PATIENCE_S and not self.said and dispatcher.py_func.__module__.startswith("irsim_gym"):
            self.said = True
            print(NOTE, file=sys.stderr, flush=True)


@functools.cache
def compilation() -> Watch:
    """Return what follows the compilations of this process, from the first call on."""
    watch = Watch()
    event.register("numba:compile", watch)  # type: ignore[no-untyped-call]
    return watch
