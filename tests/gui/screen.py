"""What a person does at a screen, and sees there: real events by xdotool, real pixels from the X server."""

from __future__ import annotations

import re
import subprocess

import numpy as np

BUTTONS = {"left": 1, "middle": 2, "right": 3, "up": 4, "down": 5}
KEYS = ("w", "a", "s", "d", "q", "e", "z", "c", "x", "r", "l", "v", "y", "alt", "shift", "space", "Escape", "F5")


class Screen:
    """One screen; windows stand in its upper left corner, because nobody manages them."""

    def __init__(self) -> None:
        from Xlib import X, display
        from Xlib.protocol.event import ClientMessage

        self._x, self._message = X, ClientMessage
        self._display = display.Display()
        self._root = self._display.screen().root

    def close(self) -> None:
        self._display.close()

    def down(self, key: str) -> None:
        """Press a key and hold it; it repeats as on any keyboard."""
        self._do("keydown", key)

    def up(self, key: str) -> None:
        self._do("keyup", key)

    def type(self, *keys: str) -> None:
        """Press keys one after another as fast as a person can: ``w``, ``alt+1``, ``Escape``, ``space``, ``F5``."""
        self._do("key", "--delay", "80", *keys)

    def move(self, column: int, row: int) -> None:
        self._do("mousemove", str(column), str(row))

    def click(self, button: str, column: int, row: int) -> None:
        """Click at a place: ``left``, ``middle``, ``right``; ``up`` and ``down`` turn the wheel by one step."""
        self.move(column, row)
        self._do("click", str(BUTTONS[button]))

    def release_all(self) -> None:
        self._do("keyup", *KEYS)

    def focus(self, title: str | None) -> None:
        """Send the keys to the window with a title, or to none."""
        window = self._x.NONE if title is None else self._window(title)
        self._display.set_input_focus(window, self._x.RevertToParent, self._x.CurrentTime)
        self._display.sync()

    def close_window(self, title: str) -> None:
        """Close a window as its cross does."""
        window = self._window(title)
        atoms = [self._display.intern_atom(name) for name in ("WM_DELETE_WINDOW", "WM_PROTOCOLS")]
        data = 32, [atoms[0], self._x.CurrentTime, 0, 0, 0]
        window.send_event(self._message(window=window, client_type=atoms[1], data=data))
        self._display.sync()

    def resize(self, title: str, width: int, height: int) -> None:
        self._window(title).configure(width=width, height=height)
        self._display.sync()

    def has_window(self, title: str) -> bool:
        """Tell whether a window with the title is to be seen."""
        return bool(self._found(title))

    def picture(self, width: int = 1280, height: int = 1024) -> np.ndarray:
        """Return what the screen shows, uint8, shape ``(height, width, 3)``."""
        image = self._root.get_image(0, 0, width, height, self._x.ZPixmap, 0xFFFFFFFF)
        return np.frombuffer(image.data, np.uint8).reshape(height, width, 4)[..., 2::-1].copy()

    def _window(self, title: str):
        found = self._found(title)
        assert found, f"no window '{title}' is to be seen"
        return self._display.create_resource_object("window", int(found[0]))

    def _found(self, title: str) -> list[str]:
        escaped = re.sub(r"([][(){}.*+?^$|\\])", r"\\\1", title)
        command = ["xdotool", "search", "--onlyvisible", "--name", f"^{escaped}$"]
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.split()

    def _do(self, *words: str) -> None:
        subprocess.run(["xdotool", *words], check=True, capture_output=True)
