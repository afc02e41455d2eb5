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
NOTE = "irsim_gym: compiling kernels for this machine, first use only (`irsim-gym warmup` does it beforehand) ..."


class _Watch(event.Listener):
    """Follows the compilations of this process; they nest, and Numba lets one thread compile at a time."""

    def __init__(self) -> None:
        self.depth = 0
        self.spent = 0.0
        self.begun = 0.0
        self.said = False
        self.collects = False

    def on_start(self, event: event.Event) -> None:
        """Pause the garbage collector, which finds next to nothing and takes a tenth of the time; say what goes on."""
        self.depth += 1
        if self.depth == 1:
            self.begun = time.perf_counter()
            self.collects = gc.isenabled()
            gc.disable()
        elif not self.said and self.spent + time.perf_counter() - self.begun > PATIENCE_S:
            self._say(event.data["dispatcher"])

    def on_end(self, event: event.Event) -> None:
        """Let the collector work again."""
        self.depth -= 1
        if self.depth == 0:
            self.spent += time.perf_counter() - self.begun
            if self.collects:
                gc.enable()
            if not self.said and self.spent > PATIENCE_S:
                self._say(event.data["dispatcher"])

    def _say(self, dispatcher: Any) -> None:
        if dispatcher.py_func.__module__.startswith("irsim_gym"):
            self.said = True
            print(NOTE, file=sys.stderr, flush=True)


@functools.cache
def watch_compilation() -> None:
    """Follow the compilations of this process from now on."""
    event.register("numba:compile", _Watch())  # type: ignore[no-untyped-call]
