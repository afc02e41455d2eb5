"""Keys from the events of a window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from irsim_gym.rendering.controls.keys import Stroke

if TYPE_CHECKING:
    from irsim_gym.rendering.windows.window import Window

SPELT = {" ": "space", "enter": "return", "": "unknown"}
"""Names of keys that matplotlib spells in another way."""


class WindowKeys:
    """Strokes in a window with the focus. They arrive while the window shows frames or waits."""

    def __init__(self, window: Window) -> None:
        self._came: list[Stroke] = []
        self._alt = False
        window.connect("key_press", lambda event: self._take(event.key, event.time, down=True))
        window.connect("key_release", lambda event: self._take(event.key, event.time, down=False))

    def strokes(self) -> list[Stroke]:
        """Return the strokes since the last call, in order."""
        came, self._came = self._came, []
        return came

    def _take(self, name: str, time: float, *, down: bool) -> None:
        """Record a key by matplotlib's name of it: ``w``, ``W`` with shift, ``alt+1``."""
        # "ctrl++" is the key "+" with a modifier; "+" alone and no name at all have nothing to split.
        *modifiers, key = [name] if name in ("+", "") else name.replace("++", "+plus").split("+")
        if key in ("alt", "alt_l", "alt_r"):
            # On some toolkits, alt is not among the modifiers of other keys.
            self._alt = down
        alt = "alt" in modifiers or self._alt
        shift = "shift" in modifiers or (len(key) == 1 and key.isupper())
        self._came.append(Stroke(SPELT.get(key, key.lower()), down, time, alt, shift))
