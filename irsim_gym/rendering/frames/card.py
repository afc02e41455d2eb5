"""Draws the surroundings of the world on a frame: paper, border, grid, ticks, and the line of text above it."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.rendering.frames.letters import Masks, Word
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.colours import colour
from irsim_gym.rendering.raster.areas import paint_line, paint_polygon
from irsim_gym.rendering.raster.masks import paint_mask
from irsim_gym.rendering.raster.records import RasterCanvas
from irsim_gym.rendering.scene.frame_layout import Layout, Limits, tick_positions

MARGIN, GAP, TIME_ROOM = 10.0, 14.0, 66.0
LONGEST_STATUS = "left world"
FEWEST_LETTERS = 3
DOT = "\N{BLACK CIRCLE}"
TICK_SIZE, NAME_SIZE, STATUS_SIZE = 7.5, 9.5, 9.0
REMEMBERED_HEADS = 512
Placed = list[tuple[int, int, int]]
"""Mask, column and row of each word."""


class Card:
    """Draws the paper, the world's border, the grid and the ticks of a layout.

    Args:
        masks: Cache of its words.
        point: Pixels per typographic point.
        axis: Whether to draw ticks and the world's border.
    """

    def __init__(self, masks: Masks, point: float, axis: bool) -> None:
        self._masks, self._point, self._axis = masks, point, axis

    def draw(self, picture: Bytes, sheet: Rays, layout: Layout) -> None:
        """Draw over a whole picture, uint8, ``(height, width, 3)``."""
        picture[:] = np.rint(colour(theme.PAPER, 1.0)[:3]).astype(np.uint8)
        corners = _snapped([_place(layout, x, y) for x, y in _corners(layout)], 0.8 * self._point)
        box = plot_box(layout)
        canvas = RasterCanvas(picture, sheet, box)
        paint_polygon(canvas, corners, 0, 4, False, np.array(colour(theme.CARD, 1.0)))
        rule = np.array(colour(theme.RULE if self._axis else theme.CARD, 1.0))
        paint_line(canvas, corners, 0, 4, 0.8 * self._point, True, True, rule)
        if self._axis:
            self._draw_ticks(picture, sheet, layout)

    def _draw_ticks(self, picture: Bytes, sheet: Rays, layout: Layout) -> None:
        columns, rows, (left, low, right, high) = ticks(layout)
        gap = 6.0 * layout.enlargement
        for x in columns:
            self._draw_rule(picture, sheet, layout, (x, low), (x, high))
        for y in rows:
            self._draw_rule(picture, sheet, layout, (left, y), (right, y))
        for x in columns:
            word = self._word(number_text(x) + (" m" if x == columns[-1] else ""))
            column, row = layout.column_row(x, low)
            self._write(picture, word, column - 0.5 * word.width, row + gap + word.height - word.foot)
        for y in rows:
            word = self._word(number_text(y))
            column, row = layout.column_row(left, y)
            self._write(picture, word, column - gap - word.width, row + 0.5 * word.height - word.foot)

    def _word(self, text: str) -> Word:
        return self._masks.word(text, TICK_SIZE * self._point)

    def _write(self, picture: Bytes, word: Word, column: float, row: float) -> None:
        ink, box = np.array(colour(theme.INK_LIGHT, 1.0)), whole_box(picture)
        paint_mask(picture, box, self._masks.levels, self._masks.rows, word.mask, round(column), round(row), ink)

    def _draw_rule(
        self, picture: Bytes, sheet: Rays, layout: Layout, start: tuple[float, float], end: tuple[float, float]
    ) -> None:
        """Draw a line of the grid, which extends half its width beyond its ends."""
        width = 0.7 * self._point
        points = _snapped([_place(layout, *start), _place(layout, *end)], width)
        axis = int(points[0, 0] == points[1, 0])
        order = 1.0 if points[1, axis] > points[0, axis] else -1.0
        points[:, axis] += np.array([-0.5, 0.5]) * order * width
        canvas, ink = RasterCanvas(picture, sheet, plot_box(layout)), np.array(colour(theme.GRID, 1.0))
        paint_line(canvas, points, 0, 2, width, False, False, ink)


class HeadText(NamedTuple):
    """A part of the line above the world.

    Attributes:
        words: The text.
        column: Its left edge [pixel].
        bold: Whether it is the name or the title.
        coloured: Whether it has the colour of the status.
    """

    words: str
    column: float
    bold: bool
    coloured: bool


class Head:
    """The line above the world: name, status and time, or a title instead.

    If the drawing area is too narrow, they use the width of the whole frame, and a text that is too long is cut.

    Args:
        masks: Cache of its words.
        point: Pixels per typographic point.
        layout: Layout of the frame.
        titled: Whether there is only a title.

    Attributes:
        middle: Row of the middle of the line [pixel].
    """

    def __init__(self, masks: Masks, point: float, layout: Layout, *, titled: bool) -> None:
        self._masks, self._layout, self._titled = masks, layout, titled
        self._name_size, self._size = NAME_SIZE * point, STATUS_SIZE * point
        self.middle = 21.0 * layout.enlargement
        self._known: dict[tuple[str, str, float], tuple[Placed, Placed, float]] = {}

    def texts(self, title: str, status: str, time: float) -> list[HeadText]:
        """Return the texts with their positions."""
        words = f"{time:.1f} s"
        if self._titled:
            return [self._title(title)]
        width = self._width(words)
        parts, right = self._line(title, status, width)
        return parts if np.isnan(right) else [*parts, HeadText(words, right - width, bold=False, coloured=False)]

    def place(self, title: str, status: str, time: float) -> tuple[Placed, Placed]:
        """Return the masks in the text colour, and those in the colour of the status.

        Nearly every frame has a new time, so the positions of the other words are cached by the width of the time.
        """
        words = f"{time:.1f} s"
        width = 0.0 if self._titled else self._width(words)
        key = title, status, width
        look = self._known.get(key)
        if look is None:
            if len(self._known) >= REMEMBERED_HEADS:
                self._known.clear()
            parts, right = ([self._title(title)], np.nan) if self._titled else self._line(*key)
            ink, coloured = ([mask for text in parts if text.coloured is flag for mask in self._masks_of(text)]
                             for flag in (False, True))  # fmt: skip
            look = self._known[key] = ink, coloured, right
        ink, coloured, right = look
        if np.isnan(right):
            return ink, coloured
        return ink + self._letters(words, right - width), coloured

    def _title(self, title: str) -> HeadText:
        margin, width = MARGIN * self._layout.enlargement, self._layout.width
        words = self._shortened(title, width - 2.0 * margin)
        half = 0.5 * self._masks.word(words, self._name_size, bold=True).width
        middle = self._layout.left + 0.5 * self._layout.plot_width
        return HeadText(words, min(max(middle, margin + half), width - margin - half) - half, bold=True, coloured=False)

    def _line(self, title: str, status: str, time_width: float) -> tuple[list[HeadText], float]:
        """Return the name, the status, and the right edge of the time; NaN if there is no room for the time."""
        layout, gap, margin = self._layout, GAP * self._layout.enlargement, MARGIN * self._layout.enlargement
        left, right = float(layout.left), float(layout.left + layout.plot_width)
        status = f"{DOT} {status.replace('_', ' ')}"
        time_room = max(time_width + gap, TIME_ROOM * layout.enlargement)
        room = max(self._width(f"{DOT} {LONGEST_STATUS}"), self._width(status)) + time_room
        if self._masks.word(title, self._name_size, bold=True).width + gap + room > right - left:
            left, right = margin, layout.width - margin
        end = right
        if room > right - left:
            time_room, end = 0.0, np.nan
        name = HeadText(self._shortened(title, right - left - room - gap), left, bold=True, coloured=False)
        return [name, HeadText(status, right - time_room - self._width(status), bold=False, coloured=True)], end

    def _masks_of(self, text: HeadText) -> Placed:
        if not text.bold:
            return self._letters(text.words, text.column)
        if not text.words:
            return []
        word = self._masks.word(text.words, self._name_size, bold=True)
        return [(word.mask, round(text.column), round(self.middle + 0.5 * word.height - word.foot))]

    def _letters(self, text: str, column: float) -> Placed:
        """Place a text letter by letter, since the text changes between frames, but its letters are cached."""
        placed, line = [], self._masks.word("lp", self._size)
        row = round(self.middle + 0.5 * line.height - line.foot)
        for letter in text:
            word = self._masks.word(letter, self._size)
            placed.append((word.mask, round(column), row))
            column += word.advance
        return placed

    def _width(self, text: str) -> float:
        return sum(self._masks.word(letter, self._size).advance for letter in text)

    def _shortened(self, words: str, room: float) -> str:
        """Cut words to a width; return an empty text if only a few letters fit."""
        short, count = words, len(words)
        while short and self._masks.word(short, self._name_size, bold=True).width > room:
            count -= 1
            short = f"{words[:count].rstrip()}\N{HORIZONTAL ELLIPSIS}" if count >= FEWEST_LETTERS else ""
        return short


def ticks(layout: Layout) -> tuple[list[float], list[float], Limits]:
    """Return the ticks of both axes [m] (empty if the world is not visible), and the visible part of the world."""
    x_min, y_min, x_max, y_max = layout.bounds
    left, below, right, above = layout.limits
    left, below, right, above = max(x_min, left), max(y_min, below), min(x_max, right), min(y_max, above)
    shown = left, below, right, above
    if left > right or below > above:
        return [], [], shown
    columns = tick_positions(left, right, layout.plot_width / layout.enlargement).tolist()
    return columns, tick_positions(below, above, layout.plot_height / layout.enlargement).tolist(), shown


def plot_box(layout: Layout) -> Ints:
    """Return the drawing area: first column, first row, end column, end row."""
    top = layout.height - layout.bottom - layout.plot_height
    sides = np.array([layout.left, top, layout.left + layout.plot_width, layout.height - layout.bottom])
    most = [layout.width, layout.height, layout.width, layout.height]
    return np.asarray(np.clip(sides, 0, most), np.int64)


def world_box(layout: Layout, margin: float) -> Ints:
    """Return the box of the visible part of the world, enlarged by a margin [pixel]."""
    left, foot = layout.column_row(*layout.bounds[:2])
    right, top = layout.column_row(*layout.bounds[2:])
    plot = plot_box(layout)
    box = np.floor(np.clip([left - margin, top - margin, right + margin, foot + margin], -1e6, 1e6) + 0.5)
    return np.array([*np.clip(box[:2], plot[:2], plot[2:]), *np.clip(box[2:], plot[:2], plot[2:])], np.int64)


def whole_box(picture: Bytes) -> Ints:
    """Return the box of a whole picture."""
    return np.array([0, 0, picture.shape[1], picture.shape[0]])


def _corners(layout: Layout) -> list[tuple[float, float]]:
    x_min, y_min, x_max, y_max = layout.bounds
    return [(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)]


def _place(layout: Layout, x: float, y: float) -> tuple[float, float]:
    """Return column and row of a point [m], rounded as in matplotlib, since many points lie exactly between pixels."""
    left = layout.limits[0]
    scale = layout.plot_width / (layout.limits[2] - left)
    return scale * x + (layout.left - left * scale), layout.column_row(x, y)[1]


def _snapped(places: list[tuple[float, float]], width: float) -> Floats:
    """Return points shifted so that a line through them fills whole pixels."""
    shift = 0.5 if round(width) % 2 == 1 else 0.0
    return np.asarray(np.floor(np.clip(places, -1e6, 1e6) + 0.5) + shift)


def number_text(value: float) -> str:
    """Return a coordinate as text for the axes."""
    return f"{round(value, 9) + 0.0:g}".replace("-", "\N{MINUS SIGN}")
