"""Paints marks over a world on frames."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.rendering.frames.card import Head, whole_box
from irsim_gym.rendering.frames.letters import Masks, Word
from irsim_gym.rendering.frames.plan import LINE_STYLES
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.colours import Colour, colour
from irsim_gym.rendering.looks.styles import faded
from irsim_gym.rendering.raster.areas import add_disc, add_polygon
from irsim_gym.rendering.raster.masks import paint_mask
from irsim_gym.rendering.raster.sheets import paint
from irsim_gym.rendering.raster.ways import add_way
from irsim_gym.rendering.scene.frame_layout import Layout
from irsim_gym.simulator.readings.marks import LineMark, Mark, Overlay, PointsMark, TextMark

REMEMBERED = 256
"""Maximum number of cached words."""


class MarkPainter:
    """Paints marks on pictures.

    Args:
        point: Pixels per typographic point.
        layout: Layout of a frame.
        shows_title: Whether there is room for a title.
    """

    def __init__(self, point: float, layout: Layout, *, shows_title: bool) -> None:
        self._point, self._layout, self._shows_title = point, layout, shows_title
        self._clear_words()

    def _clear_words(self) -> None:
        """Clear the cache of words."""
        self._masks = Masks()
        self._head = Head(self._masks, self._point, self._layout, titled=True)

    def prepare(self, overlays: Iterable[Overlay]) -> None:
        """Make the masks of texts and titles before threads paint them."""
        if len(self._masks.rows) > REMEMBERED:
            self._clear_words()
        for overlay in overlays:
            for mark in overlay.marks:
                if isinstance(mark, TextMark):
                    self._word(mark)
            if overlay.title is not None:
                self._head.place(overlay.title, "", 0.0)

    def write_title(self, picture: Bytes, title: str) -> None:
        """Write a title in place of name, status and time."""
        ink, masks = np.array(colour(theme.INK, 1.0)), self._masks
        for place in self._head.place(title, "", 0.0)[0] if self._shows_title else ():
            paint_mask(picture, whole_box(picture), masks.levels, masks.rows, *place, ink)

    def paint(self, picture: Bytes, sheet: Rays, box: Ints, layout: Layout, marks: Sequence[Mark]) -> None:
        """Paint marks on a picture, in order.

        Args:
            picture: uint8, shape ``(height, width, 3)``.
            sheet: An empty sheet of its size.
            box: Box of the world on the picture.
            layout: Layout of the picture.
            marks: The marks of one layer; texts are painted last.
        """
        for mark in marks:
            if isinstance(mark, LineMark):
                self._paint_line(picture, sheet, box, layout, mark)
            elif isinstance(mark, PointsMark):
                self._paint_points(picture, sheet, box, layout, mark)
        for mark in marks:
            if isinstance(mark, TextMark) and layout.contains(mark.x, mark.y):
                self._write(picture, layout, mark)

    def _paint_line(self, picture: Bytes, sheet: Rays, box: Ints, layout: Layout, mark: LineMark) -> None:
        places = _pixels(layout, mark.points)
        if mark.fill:
            add_polygon(sheet, box, places, 0, len(places))
            paint(picture, sheet, box, _ink(mark.fill, mark.alpha), False)
        if mark.width > 0.0:
            self._add_way(sheet, box, places, mark.width, LINE_STYLES[mark.style], closed=mark.closed)
            paint(picture, sheet, box, _ink(mark.color, mark.alpha), False)

    def _paint_points(self, picture: Bytes, sheet: Rays, box: Ints, layout: Layout, mark: PointsMark) -> None:
        ink, size = _ink(mark.color, mark.alpha), mark.size * self._point
        form = [size * part * np.array([1.0, -1.0]) for part in mark.form]
        for place in _pixels(layout, mark.points):
            if not form:
                add_disc(sheet, box, place[0], place[1], 0.5 * size, 1.0)
            for part in form:
                if mark.width > 0.0:
                    self._add_way(sheet, box, part + place, mark.width, LINE_STYLES["solid"], closed=False)
                else:
                    add_polygon(sheet, box, part + place, 0, len(part))
            if ink[3] < 1.0:  # opaque marks can share one area
                paint(picture, sheet, box, ink, False)
        paint(picture, sheet, box, ink, False)

    def _add_way(self, sheet: Rays, box: Ints, places: Floats, width: float, style: int, *, closed: bool) -> None:
        """Add a line to a sheet."""
        room = np.empty((2 * len(places) + 4, 2))
        room[: len(places)] = places
        add_way(sheet, box, room, len(places), (width * self._point, style, 0.0), closed, False)

    def _write(self, picture: Bytes, layout: Layout, mark: TextMark) -> None:
        word = self._word(mark)
        column, row = layout.column_row(mark.x, mark.y)
        left = column - {"left": 0.0, "center": 0.5, "right": 1.0}[mark.align] * word.width
        place = round(left), round(row + 0.5 * word.height - word.foot)
        masks, ink = self._masks, _ink(mark.color, mark.alpha)
        paint_mask(picture, whole_box(picture), masks.levels, masks.rows, word.mask, *place, ink)

    def _word(self, mark: TextMark) -> Word:
        return self._masks.word(mark.text, mark.size * self._point)


def marks_by_layer(overlay: Overlay) -> Iterator[tuple[float, list[Mark]]]:
    """Yield layers with their marks, the lowest first."""
    marks: dict[float, list[Mark]] = {}
    for mark in overlay.marks:
        marks.setdefault(mark.layer, []).append(mark)
    yield from sorted(marks.items())


def _ink(name: str, alpha: float) -> Floats:
    tone: Colour = colour(*faded(name, alpha))
    return np.array(tone)


def _pixels(layout: Layout, points: Floats) -> Floats:
    """Return columns and rows of points [m]."""
    return np.asarray(np.array(layout.column_row(0.0, 0.0)) + points * np.array([layout.scale, -layout.scale]))
