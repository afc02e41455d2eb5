"""Texts: drawn by matplotlib once, kept as strips of pixels, and then only put where they belong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import Stroke
from matplotlib.text import Text

from irsim_gym.arraytypes import Bytes
from irsim_gym.render import fonts, theme
from irsim_gym.render.brush import Brush

TEXT: dict[str, Any] = {"family": theme.FONT, "parse_math": False, "usetex": False}
PARTS = 2
"""A strip is drawn at halves of a pixel each way, so that a text that moves does not jump."""
REMEMBERED = 2048
MARGIN = 4
HALO = 3.0
"""Width of the line that makes a halo: half of it is seen beside a letter [point]."""


@dataclass(frozen=True)
class Type:
    """How a text looks and which of its points stands at its place.

    Attributes:
        size: Its size [point].
        colour: Its colour.
        alpha: Its opacity.
        weight: ``normal`` or ``bold``.
        align: ``left``, ``center`` or ``right``.
        level: ``bottom`` or ``center``.
        halo: Colour of a rim around the letters, for words over anything; none if empty.
    """

    size: float
    colour: str
    alpha: float = 1.0
    weight: str = "normal"
    align: str = "left"
    level: str = "center"
    halo: str = ""


@dataclass(frozen=True, eq=False)
class Strip:
    """A text as pixels.

    Attributes:
        pixels: Colours and opacity, row 0 at the bottom, shape ``(height, width, 4)``.
        column: Its left edge, counted from the pixel of the text's place.
        row: Its lower edge, likewise.
    """

    pixels: Bytes
    column: int
    row: int


class Lettering:
    """Writes on one figure.

    Args:
        figure: The figure, for its resolution and size.
    """

    def __init__(self, figure: Figure) -> None:
        self._figure = figure
        self._text = Text(**TEXT)
        self._text.set_figure(figure)
        self._strips: dict[tuple[str, Type, int, int], Strip | None] = {}
        self._widths: dict[tuple[str, float, str], float] = {}
        self._sheet: Any = None

    def write(self, brush: Brush, words: str, x: float, y: float, look: Type) -> None:
        """Write words at a place on the canvas."""
        if not brush.keeps_strips:
            self._set(words, x, y, look)
            if brush.context.get_clip_rectangle() is not None:
                self._text.set_clip_box(brush.context.get_clip_rectangle())
            self._paint(brush.renderer, look)
            self._text.set_clip_box(None)  # strips are drawn on a sheet of their own
            return
        columns, rows = round(PARTS * x), round(PARTS * y)
        key = words, look, columns % PARTS, rows % PARTS
        strip = self._strips[key] if key in self._strips else self._drawn(*key)
        if strip is not None:
            left, low = columns // PARTS + strip.column, rows // PARTS + strip.row
            brush.strip(strip.pixels, left, low)

    def write_letters(self, brush: Brush, words: str, right: float, y: float, look: Type) -> None:
        """Write words that change with every frame, letter by letter, so that their strips are found again."""
        if not brush.keeps_strips:
            self.write(brush, words, right, y, look)
            return
        x, single = right - self.width_of_letters(brush, words, look), replace(look, align="left")
        for letter in words:
            self.write(brush, letter, x, y, single)
            x += self._advance(brush, letter, look)

    def width_of_letters(self, brush: Brush, words: str, look: Type) -> float:
        """Return the width of words on the canvas, as the sum of their letters'."""
        return sum(self._advance(brush, letter, look) for letter in words)

    def _advance(self, brush: Brush, letter: str, look: Type) -> float:
        """Return how much farther the next letter stands."""
        return self.width(brush, f"0{letter}0", look) - self.width(brush, "00", look)

    def width(self, brush: Brush, words: str, look: Type) -> float:
        """Return the width of words on the canvas; of those on a canvas of pixels it is worked out once."""
        key = words, look.size, look.weight
        if not brush.keeps_strips or key not in self._widths:
            self._set(words, 0.0, 0.0, look)
            width = float(self._text.get_window_extent(brush.renderer).width)
            if not brush.keeps_strips:
                return width
            _make_room(self._widths)
            self._widths[key] = width
        return self._widths[key]

    def _set(self, words: str, x: float, y: float, look: Type) -> None:
        words, face = fonts.families(words, bold=look.weight == "bold")
        self._text.set(**face, position=(x, y), text=words, color=look.colour, alpha=look.alpha, fontsize=look.size)
        self._text.set(ha=look.align, va=look.level)

    def _paint(self, renderer: Any, look: Type) -> None:
        """Draw the text that is set; its halo apart and before it, so that a file holds the letters as letters."""
        if look.halo:
            self._text.set_path_effects([Stroke(linewidth=HALO, foreground=look.halo)])
            self._text.draw(renderer)
            self._text.set_path_effects([])
        self._text.draw(renderer)

    def _drawn(self, words: str, look: Type, column_part: int, row_part: int) -> Strip | None:
        """Return a new strip, with the text's place some parts of a pixel from a corner; None if nothing is seen."""
        _make_room(self._strips)
        strip = self._draw(words, look, column_part, row_part) if words.strip() else None
        self._strips[words, look, column_part, row_part] = strip
        return strip

    def _draw(self, words: str, look: Type, column_part: int, row_part: int) -> Strip | None:
        self._set(words, 0.0, 0.0, look)
        sheet = self._sheet_for(words)
        box = self._text.get_window_extent(sheet)
        left, low = MARGIN - int(np.floor(box.x0)), MARGIN - int(np.floor(box.y0))
        self._text.set_position((left + column_part / PARTS, low + row_part / PARTS))
        sheet.clear()
        self._paint(sheet, look)
        pixels = np.asarray(sheet.buffer_rgba())
        rows, columns = np.nonzero(pixels[..., 3])
        if not len(rows):
            return None
        cut = pixels[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1][::-1].copy()
        return Strip(cut, int(columns.min()) - left, pixels.shape[0] - 1 - int(rows.max()) - low)

    def _sheet_for(self, words: str) -> Any:
        """Return a canvas that is large enough for the words that are set."""
        dpi = self._figure.dpi
        if self._sheet is None:
            self._sheet = _sheet(256, 64, dpi)
        box = self._text.get_window_extent(self._sheet)
        width, height = box.width + 2 * MARGIN + 2, box.height + 2 * MARGIN + 2
        if width > self._sheet.width or height > self._sheet.height:
            self._sheet = _sheet(max(width, self._sheet.width), max(height, self._sheet.height), dpi)
        return self._sheet


def _sheet(width: float, height: float, dpi: float) -> Any:
    make: Any = RendererAgg
    return make(width, height, dpi)


def _make_room(known: dict[Any, Any]) -> None:
    """Forget what was known first where there is much."""
    if len(known) >= REMEMBERED:
        known.pop(next(iter(known)))
