"""The line above the drawing area."""

from __future__ import annotations

from typing import Any

from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.text import Text

from irsim_gym.render import theme
from irsim_gym.render.card import TEXT
from irsim_gym.render.layout import Layout
from irsim_gym.render.scene import Scene

MARGIN, GAP, TIME_ROOM = 10.0, 14.0, 66.0
LONGEST_STATUS = "left world"
FEWEST_LETTERS = 3


class Head:
    """Name on the left, status and time on the right; or a title that takes the place of all three.

    Where the drawing area is too narrow they spread over the whole picture, and a text that is too long is cut.

    Args:
        figure: Where it is drawn.
        layout: Where things stand on it.
        titled: There is a title.
    """

    def __init__(self, figure: Figure, layout: Layout, *, titled: bool) -> None:
        self._figure, self._titled = figure, titled
        self._pixel = layout.enlargement / layout.width
        y = 1.0 - 21.0 * layout.enlargement / layout.height
        self._left, self._right = layout.left / layout.width, (layout.left + layout.plot_width) / layout.width
        common: dict[str, Any] = {**TEXT, "va": "center", "animated": True}
        self._name = figure.text(0.0, y, "", color=theme.INK, fontsize=9.5, weight="bold", **common)
        self._time = figure.text(0.0, y, "", color=theme.INK, fontsize=9.0, ha="right", **common)
        self._status = figure.text(0.0, y, "", fontsize=9.0, ha="right", **common)
        self._cut: tuple[str, float, str] = ("", 0.0, "")

    def draw(self, renderer: RendererBase, scene: Scene) -> None:
        """Draw name, status and time of a scene, or its title."""
        if self._titled:
            self._draw_title(renderer, scene.title)
        else:
            self._draw_line(renderer, scene)

    def _draw_title(self, renderer: RendererBase, title: str) -> None:
        """Draw the title over the middle of the drawing area, as far as the picture's edges let it."""
        margin = MARGIN * self._pixel
        words = self._shortened(renderer, title, 1.0 - 2.0 * margin)
        half = 0.5 * self._width(renderer, self._name, words)
        middle = min(max(0.5 * (self._left + self._right), margin + half), 1.0 - margin - half)
        self._name.set(text=words, x=middle - half)
        self._name.draw(renderer)

    def _draw_line(self, renderer: RendererBase, scene: Scene) -> None:
        left, right, gap = self._left, self._right, GAP * self._pixel
        status = f"\N{BLACK CIRCLE} {scene.status.replace('_', ' ')}"
        time = f"{scene.time:.1f} s"
        widths = (
            self._width(renderer, self._status, words) for words in (f"\N{BLACK CIRCLE} {LONGEST_STATUS}", status)
        )
        time_room = max(self._width(renderer, self._time, time) + gap, TIME_ROOM * self._pixel)
        room = max(widths) + time_room
        if self._width(renderer, self._name, scene.title) + gap + room > right - left:
            left, right = MARGIN * self._pixel, 1.0 - MARGIN * self._pixel
        if room > right - left:
            time, time_room = "", 0.0
        self._status.set(text=status, x=right - time_room, color=theme.status_colour(scene.status))
        self._time.set(text=time, x=right)
        self._name.set(text=self._shortened(renderer, scene.title, right - left - room - gap), x=left)
        for text in (self._name, self._status, self._time):
            text.draw(renderer)

    def _width(self, renderer: RendererBase, text: Text, words: str) -> float:
        """Return the width of words as a share of the picture's."""
        text.set_text(words)
        return float(text.get_window_extent(renderer).width / self._figure.bbox.width)

    def _shortened(self, renderer: RendererBase, words: str, room: float) -> str:
        """Cut words to a room; nothing is left where hardly a letter has room."""
        if self._cut[:2] == (words, room):
            return self._cut[2]
        short, count = words, len(words)
        while self._width(renderer, self._name, short) > room and short:
            count -= 1
            short = f"{words[:count].rstrip()}\N{HORIZONTAL ELLIPSIS}" if count >= FEWEST_LETTERS else ""
        self._cut = words, room, short
        return short
