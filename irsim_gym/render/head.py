"""The line above the drawing area."""

from __future__ import annotations

from matplotlib.transforms import Bbox

from irsim_gym.render import theme
from irsim_gym.render.brush import Brush
from irsim_gym.render.layout import DOTS_PER_INCH, POINTS_PER_INCH, Layout
from irsim_gym.render.lettering import Lettering, Type
from irsim_gym.render.scene import Scene

MARGIN, GAP, TIME_ROOM, ABOVE = 10.0, 14.0, 66.0, 21.0
LONGEST_STATUS = "left world"
FEWEST_LETTERS = 3
NAME = Type(9.5, theme.INK, weight="bold")
TIME = Type(9.0, theme.INK, align="right")


class Head:
    """Name on the left, status and time on the right; or a title that takes the place of all three.

    Where the drawing area is too narrow they spread over the whole picture, and a text that is too long is cut.

    Args:
        lettering: Who writes.
        layout: Where things stand on it.
        titled: There is a title.
    """

    def __init__(self, lettering: Lettering, layout: Layout, *, titled: bool) -> None:
        self._lettering, self._layout, self._titled = lettering, layout, titled
        self._cut: tuple[str, float, str] = ("", 0.0, "")

    def draw(self, brush: Brush, scene: Scene) -> None:
        """Draw name, status and time of a scene, or its title."""
        level = self._level(brush)
        for words, x, look in self._texts(brush, scene):
            write = self._lettering.write_letters if look is TIME else self._lettering.write
            write(brush, words, brush.corner[0] + x, level, look)

    def extent(self, brush: Brush, scene: Scene) -> Bbox:
        """Return the part of the canvas that is written on."""
        spans = [
            (x - self._lettering.width(brush, words, look), x)
            if look.align == "right"
            else (x, x + self._lettering.width(brush, words, look))
            for words, x, look in self._texts(brush, scene)
        ]
        left, right = min(low for low, _ in spans), max(high for _, high in spans)
        level, half = self._level(brush), 0.55 * NAME.size * brush.point
        return Bbox.from_extents(brush.corner[0] + left, level - half, brush.corner[0] + right, level + half)

    def _texts(self, brush: Brush, scene: Scene) -> tuple[tuple[str, float, Type], ...]:
        """Return texts, where they stand across and how they look."""
        pixel = self._pixel(brush)
        by_hand = scene.overlay.title
        if self._titled or by_hand is not None:
            return self._title(brush, scene.title if by_hand is None else by_hand, pixel)
        return self._line(brush, scene, pixel)

    def _title(self, brush: Brush, title: str, pixel: float) -> tuple[tuple[str, float, Type], ...]:
        """Return the title, over the middle of the drawing area, as far as the picture's edges let it."""
        layout = self._layout
        margin, whole = MARGIN * layout.enlargement * pixel, layout.width * pixel
        words = self._shortened(brush, title, whole - 2.0 * margin)
        half = 0.5 * self._lettering.width(brush, words, NAME)
        middle = min(max((layout.left + 0.5 * layout.plot_width) * pixel, margin + half), whole - margin - half)
        return ((words, middle - half, NAME),)

    def _line(self, brush: Brush, scene: Scene, pixel: float) -> tuple[tuple[str, float, Type], ...]:
        layout, width, unit = self._layout, self._lettering.width, self._layout.enlargement * pixel
        left, right, gap = layout.left * pixel, (layout.left + layout.plot_width) * pixel, GAP * unit
        status, time = f"\N{BLACK CIRCLE} {scene.status.replace('_', ' ')}", f"{scene.time:.1f} s"
        look = Type(9.0, theme.status_colour(scene.status), align="right")
        time_room = max(self._lettering.width_of_letters(brush, time, TIME) + gap, TIME_ROOM * unit)
        room = time_room + max(width(brush, words, look) for words in (f"\N{BLACK CIRCLE} {LONGEST_STATUS}", status))
        if width(brush, scene.title, NAME) + gap + room > right - left:
            left, right = MARGIN * unit, layout.width * pixel - MARGIN * unit
        if room > right - left:
            time, time_room = "", 0.0
        name = self._shortened(brush, scene.title, right - left - room - gap)
        return (name, left, NAME), (status, right - time_room, look), (time, right, TIME)

    def _pixel(self, brush: Brush) -> float:
        """Return how many units of the canvas are a pixel of a frame."""
        return brush.point * POINTS_PER_INCH / (DOTS_PER_INCH * self._layout.enlargement)

    def _level(self, brush: Brush) -> float:
        """Return where the line's middle is on the canvas."""
        return brush.corner[1] + (self._layout.height - ABOVE * self._layout.enlargement) * self._pixel(brush)

    def _shortened(self, brush: Brush, words: str, room: float) -> str:
        """Cut words to a room; nothing is left where hardly a letter has room."""
        if self._cut[:2] == (words, room):
            return self._cut[2]
        short, count = words, len(words)
        while self._lettering.width(brush, short, NAME) > room and short:
            count -= 1
            short = f"{words[:count].rstrip()}\N{HORIZONTAL ELLIPSIS}" if count >= FEWEST_LETTERS else ""
        self._cut = words, room, short
        return short
