"""Keys from the operating system, by the package pynput."""

import time
from collections import deque
from collections.abc import Callable
from typing import Any

from irsim_gym.rendering.controls.keys import KeySource, Stroke

SPELT = {"esc": "escape", "enter": "return"}
"""Names of keys that pynput spells in another way."""
ENDING_S = 2.0
"""Time in which the thread has to end [s]."""


class PynputKeys(KeySource):
    """Strokes of the keyboard in any window; they arrive in a thread of pynput.

    Args:
        is_focused: Returns whether the program has the focus; while it is false, key presses are ignored. ``strokes``
            calls it, in the caller's thread.

    Raises:
        ImportError: If pynput is not installed, or finds no keyboard.
    """

    name = "pynput"

    def __init__(self, is_focused: Callable[[], bool]) -> None:
        from pynput import keyboard

        self._is_focused = is_focused
        self._came: deque[Stroke] = deque()
        self._alt = self._shift = False
        self._listener: Any = keyboard.Listener(on_press=self._pressed, on_release=self._released)
        self._listener.daemon = True
        self._listener.start()
        self._listener.wait()

    def strokes(self) -> list[Stroke]:
        """Return the strokes since the last call in order, without presses if the program lacks the focus."""
        focused = self._is_focused()
        # Strokes may arrive meanwhile in the other thread: only as many are taken as there are now.
        came = [self._came.popleft() for _ in range(len(self._came))]
        return [stroke for stroke in came if focused or not stroke.down]

    def close(self) -> None:
        """Stop the thread."""
        if not self._listener.is_alive():
            return
        connection, context = (getattr(self._listener, name, None) for name in ("_display_stop", "_context"))
        if connection is None or context is None:
            self._listener.stop()
            self._listener.join(ENDING_S)
            return
        # Under X, stop() of pynput takes effect only at the next key, since its thread blocks on the connection that
        # should end. A second connection can end the recording at once, but not before it has fully started.
        another = type(connection)()
        for _ in range(20):
            another.record_disable_context(context)
            another.sync()
            self._listener.join(ENDING_S / 20)
            if not self._listener.is_alive():
                break
        another.close()

    def _pressed(self, key: object, *_: object) -> None:
        self._take(key, down=True)

    def _released(self, key: object, *_: object) -> None:
        self._take(key, down=False)

    def _take(self, key: object, *, down: bool) -> None:
        name = _plain_name(key)
        if name.startswith("alt"):
            self._alt = down
        if name.startswith("shift"):
            self._shift = down
        self._came.append(Stroke(name, down, time.perf_counter(), self._alt, self._shift))


def _plain_name(key: object) -> str:
    """Return the name of one of pynput's keys: its character in lower case, or else its name."""
    char = getattr(key, "char", None)
    if char is not None:
        return str(char).lower()
    name = str(getattr(key, "name", None) or "unknown")
    return SPELT.get(name, name)
