"""Announces compilations that take long, and pauses the garbage collector meanwhile."""

import functools
import gc
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

PATIENCE_S = 1.0
"""Seconds of compiling before anything is said."""
ONCE = "for this machine, first use only (`irsim-gym warmup` does it beforehand)"


class Watch:
    """Follows the compilations of this process; they nest, and Numba lets one thread compile at a time.

    Attributes:
        compiled: How many kernels this process has compiled.
        received: How many entries of kernels other processes have compiled while this one was about to.
        spent: How long that took [s].
        waited: How long this process has waited for others that compile [s].
        said: Whether a note has been printed, so that nothing more follows.
        expected: About how many kernels this process and others compile together; 0 if that is not known.
    """

    def __init__(self) -> None:
        self.compiled = 0
        self.received = 0
        self.spent = 0.0
        self.waited = 0.0
        self.said = False
        self.expected = 0
        self._count: Callable[[], int] = int
        self._depth = 0
        self._begun = 0.0
        self._collects = False
        self._is_shown = False

    def on_start(self, event: Any) -> None:
        """Pause the garbage collector, which finds next to nothing and takes a tenth of the time; report progress."""
        # Compiling a kernel compiles those that it calls: only the outermost start and end are timed.
        self._depth += 1
        if self._depth == 1:
            self._begun = time.perf_counter()
            self._collects = gc.isenabled()
            gc.disable()
        spent = self.spent + time.perf_counter() - self._begun
        function = event.data["dispatcher"].py_func
        if function.__module__.startswith("irsim_gym"):
            what = f"about {self.expected} kernels" if self.expected else "kernels"
            now = f", now {function.__name__}"
            self._say(spent, lambda: (self._progress() or f"{self.compiled} done in {spent:.0f} s") + now, what)

    def on_end(self, event: Any) -> None:
        """Resume the garbage collector."""
        self._depth -= 1
        self.compiled += 1
        if self._depth == 0:
            self.spent += time.perf_counter() - self._begun
            self._clear()
            if self._collects:
                gc.enable()

    def on_wait(self, seconds: float) -> None:
        """Report on a terminal that another process compiles what this one needs; elsewhere that one reports."""
        self.waited += seconds
        waiting = f"waiting for another process for {self.waited:.0f} s"
        self._say(self.waited, lambda: f"{self._progress()}, {waiting}" if self.expected else waiting)

    def on_wait_end(self) -> None:
        """Clear the line of the terminal."""
        if self._depth == 0:
            self._clear()

    @contextmanager
    def expecting(self, n_kernels: int, count: Callable[[], int]) -> Iterator[None]:
        """Report progress as a share of all kernels while the body runs; ``count`` returns how many are on disk."""
        before = count()
        self.expected, self._count = n_kernels, lambda: count() - before
        try:
            yield
        finally:
            self.expected = 0

    def _progress(self) -> str:
        return f"kernel {self._count() + 1} of about {self.expected}" if self.expected else ""

    def _say(self, spent: float, progress: Callable[[], str], what: str = "") -> None:
        """Report what takes a while: on a terminal in a line that is overwritten, elsewhere once.

        Args:
            spent: For how long it has been going on [s].
            progress: Returns how far it is, for a terminal.
            what: What is compiled, for other places; nothing by default.
        """
        if spent <= PATIENCE_S or self.said:
            return
        if self._is_shown or is_terminal():
            self._is_shown = True
            write_over(f"irsim_gym: compiling kernels for this machine, once: {progress()}")
        elif what:
            self.said = True
            print(f"irsim_gym: compiling {what} {ONCE}", file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if self._is_shown:
            self._is_shown = False
            write_over("")


def is_terminal() -> bool:
    """Return whether a line on the screen can be written over."""
    file = getattr(sys.stderr, "rich_proxied_file", sys.stderr)
    return file is not None and file.isatty() and os.environ.get("TERM") != "dumb"


def write_over(line: str) -> None:
    """Write a line over the last one of the terminal, and stay in it."""
    from rich.console import Console
    from rich.control import Control
    from rich.segment import ControlType
    from rich.text import Text

    # Progress bars of rich hold back what is written to stderr until its line ends: this goes past them. They draw
    # themselves again, so it may cover one.
    screen = Console(file=getattr(sys.stderr, "rich_proxied_file", sys.stderr))
    screen.control(Control(ControlType.CARRIAGE_RETURN, (ControlType.ERASE_IN_LINE, 2)))
    screen.print(Text(line, end="", no_wrap=True, overflow="ellipsis"), end="", soft_wrap=False)


@functools.cache
def compilation() -> Watch:
    """Return what follows the compilations of this process, from the first call on."""
    watch = Watch()
    try:
        from numba.core import event

        class Listener(event.Listener):
            on_start, on_end = staticmethod(watch.on_start), staticmethod(watch.on_end)

        event.register("numba:compile", Listener())  # type: ignore[no-untyped-call]
    except (ImportError, AttributeError):  # a Numba without these events: nothing is announced
        pass
    return watch
