"""A window that shows a simulation in real time."""

from __future__ import annotations

import os
import threading
import time
import warnings
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from irsim_gym.base.arraytypes import Bytes

if TYPE_CHECKING:
    from irsim_gym.rendering.windows.window import Window


class Screen:
    """Shows pictures in real time, in a window that opens with the first picture.

    If the user closes the window, later pictures are ignored, with one warning. A copy opens its own window. In a
    forked process, the window remains with the parent process, and pictures are ignored, with a warning.

    Args:
        title: Title of the window.
    """

    def __init__(self, title: str) -> None:
        self.title = title
        self._window: Window | None = None
        self._shown_until = 0.0
        self._process = 0
        self._given_up = False
        self._inherited: Window | None = None
        self._end: Callable[[], object] = _nothing

    @property
    def is_wanted(self) -> bool:
        """Whether pictures are shown: False after the user has closed the window, or in a forked process."""
        self._check_window()
        return not self._given_up

    @property
    def window(self) -> Window | None:
        """The window, once it is open."""
        return self._window

    def show(self, picture: Bytes, seconds: float = 0.0) -> None:
        """Show a picture after the previous one has been shown for its time.

        Args:
            picture: uint8, shape ``(height, width, 3)``.
            seconds: Time in the world since the previous picture [s].

        Raises:
            NoWindowError: If there is no display or no working toolkit.
        """
        if not self.is_wanted:
            return
        if self._window is None:
            from irsim_gym.rendering.windows.window import Window

            self._window = Window(picture.shape[1], picture.shape[0], self.title)
            self._process = os.getpid()
            self._end = weakref.finalize(self, _close, self._window, self._process, threading.get_ident())
            self._shown_until = time.perf_counter()
        else:
            # Pictures keep to a common clock, so that small delays do not add up; a long one starts it anew.
            due = self._shown_until + seconds
            self._window.wait(due - time.perf_counter())
            late = time.perf_counter() - due
            self._shown_until = due if late < seconds else due + late
        self._window.show(picture)
        self._check_window()

    def refresh(self) -> None:
        """Process the window's pending events."""
        self._check_window()
        if self._window is not None:
            self._window.wait(0.0)
            self._check_window()

    def close(self) -> None:
        """Close the window. A later picture opens a new one."""
        self._check_window(warn=False)
        if self._window is not None:
            self._window.close()
            self._end()
        self._window, self._given_up = None, False

    def _check_window(self, *, warn: bool = True) -> None:
        """Drop a window that was closed, or that belongs to the parent of this forked process."""
        if self._window is None:
            return
        if self._process != os.getpid():
            # Kept alive: closing it, or opening another one, would break the parent's connection to the display.
            self._inherited, self._window, self._given_up = self._window, None, True
            if warn:
                warnings.warn("the window is the parent process's: this one goes on without a window", stacklevel=2)
        elif self._window.closed:
            self._window, self._given_up = None, True
            self._end()
            if warn:
                warnings.warn("the window was closed: the environment goes on without one", stacklevel=2)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_window": None, "_inherited": None, "_given_up": False, "_end": _nothing}


def _close(window: Window, process: int, thread: int) -> None:
    """Close the window of a deleted screen, if this is the process and thread that opened it."""
    if (process, thread) == (os.getpid(), threading.get_ident()):
        window.close()


def _nothing() -> None:
    pass
