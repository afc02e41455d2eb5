"""Marks drawn over a world, and how long each stays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.live import arrows, looks, places, strokes
from irsim_gym.live.looks import Color, Colors
from irsim_gym.world.marks import NOTHING, ON_TOP, LineMark, Mark, Overlay, TextMark

PATH, ARROW, INK = "#0072B2", "black", "#1F2933"
LINE_LAYER, GROUND_LAYER = 2.0, 1.0
LARGEST_TEXT = 200.0
"""Size of the largest text [point]."""
STAYS, FRESH, OLD = range(3)
"""Marks that stay, those for one picture, and those of them that nobody has rendered at their own moment."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """What one call has drawn.

    Attributes:
        drawing: Where it is.
        marks: The marks.
    """

    drawing: Drawing
    marks: tuple[Mark, ...]

    def remove(self) -> None:
        """Take it away; nothing happens where it is gone already."""
        self.drawing.remove(self)


class Drawing:
    """Marks over a world: ways, points, areas, arrows, texts. They are seen in pictures and change nothing else.

    They are in what ``render`` returns and shows, in saved figures, films and replays, with either renderer, but only
    inside the world's rectangle. A mark stays until it is removed, also after a reset; one that is drawn with
    ``once=True`` is in the next picture that ``render`` draws, and gone afterwards. Where nobody renders, a film shows
    it at the moment at which it was drawn. Nothing is drawn for empty lists.

    Points are rows ``x, y`` [m]: an array of shape ``(n, 2)`` or a list; what a row holds after that is not used. A
    point that is not finite, or 1e9 m away, is left out and interrupts a line. Colours are matplotlib's: ``"red"``,
    ``"C0"``, ``"#d62728"``, ``(0.8, 0.1, 0.1)``. Widths and sizes are points of type, which do not grow with the
    world. Marks in a higher ``layer`` cover what is in a lower one: obstacles are in layer 1, robots in 3.
    """

    def __init__(self) -> None:
        self._marks: list[tuple[Mark, int]] = []
        self._title: str | None = None
        self._overlays: dict[bool, Overlay] = {}
        self._is_changed = False

    def __len__(self) -> int:
        return len(self._marks)

    def path(
        self,
        points: ArrayLike,
        format: str = "-",
        *,
        color: Color | None = None,
        width: float = 1.5,
        alpha: float = 1.0,
        layer: float = LINE_LAYER,
        once: bool = False,
    ) -> Drawn:
        """Draw a line through points.

        Args:
            points: The points [m].
            format: Colour, form of the points and line style as matplotlib writes them, such as ``"g--"`` or ``"ro"``.
            color: The colour; by default that of the format, else blue.
            width: Its width [point].
            alpha: Its opacity.
            layer: Its layer.
            once: Only for the next picture.

        Raises:
            ValueError: These are no points, or there is no such format, colour, width, opacity or layer.
        """
        look = looks.parsed(format)
        ink = strokes.StrokeInk.of(color if color is not None else look.color or PATH, alpha, layer)
        return self.add(strokes.line(places.rows(points), look, ink, width), once)

    def points(
        self,
        points: ArrayLike,
        *,
        color: Colors | None = None,
        size: float = 6.5,
        marker: str = "o",
        alpha: float = 1.0,
        layer: float = GROUND_LAYER,
        once: bool = False,
    ) -> Drawn:
        """Mark points.

        Args:
            points: The points [m].
            color: Their colour, or a list with a colour for each; pink by default.
            size: Their diameter [point].
            marker: Their form, one of ``o . , s ^ v < > D d p h * | _ + x``.
            alpha: Their opacity.
            layer: Their layer.
            once: Only for the next picture.

        Raises:
            ValueError: These are no points, or there is no such colour, size, form, opacity or layer.
        """
        rows = places.rows(points)
        return self.add(strokes.points(rows, color, marker, size, strokes.MARKER_WIDTH, alpha, layer), once)

    def polygon(
        self,
        points: ArrayLike,
        *,
        color: Color | None = PATH,
        fill: Color | None = None,
        width: float = 1.5,
        style: str = "-",
        alpha: float = 1.0,
        layer: float = LINE_LAYER,
        once: bool = False,
    ) -> Drawn:
        """Draw a polygon.

        Args:
            points: Its corners [m], at least three; the last one need not repeat the first.
            color: Colour of its edge; None for no edge.
            fill: Colour of its area; None for an edge alone.
            width: Width of its edge [point].
            style: Style of its edge: ``-``, ``--``, ``-.`` or ``:``.
            alpha: Opacity of both.
            layer: Its layer.
            once: Only for the next picture.

        Raises:
            ValueError: These are not three points, or there is no such colour, width, style, opacity or layer.
        """
        edge = strokes.StrokeInk.of(color, alpha, layer)
        return self.add(strokes.area(places.rows(points), edge, fill, looks.line_style(style), width), once)

    def arrows(
        self,
        tails: ArrayLike,
        vectors: ArrayLike,
        *,
        length: float | None = None,
        width: float | None = None,
        color: Color | None = ARROW,
        alpha: float = 1.0,
        layer: float = GROUND_LAYER,
        once: bool = False,
    ) -> Drawn:
        """Draw arrows.

        Args:
            tails: Where they begin [m].
            vectors: A row ``u, v`` for each: direction and, where no ``length`` is given, length [m]. A vector of
                length 0 has no arrow.
            length: Length of all of them [m].
            width: Width of their shafts [m]; by default a sixteenth of their mean length. Heads are three times as
                wide.
            color: Their colour.
            alpha: Their opacity.
            layer: Their layer.
            once: Only for the next picture.

        Raises:
            ValueError: There are not as many vectors as points, or no such length, width, colour, opacity or layer.
        """
        begins, ways = places.rows(tails)[:, :2], places.rows(vectors)[:, :2]
        if len(begins) != len(ways):
            raise ValueError(f"each arrow has a tail and a vector, got {len(begins)} tails and {len(ways)} vectors")
        size = None if length is None else looks.number("length", length)
        thick = None if width is None else looks.number("width", width)
        ink = strokes.StrokeInk.of(color, alpha, layer)
        outlines = arrows.outlines(np.hstack([begins, ways]), size, thick)
        marks = [LineMark(way, ink.color, ink.alpha, 0.0, "solid", True, ink.color, ink.layer) for way in outlines]
        return self.add(marks if ink.is_seen else [], once)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        *,
        size: float = 8.0,
        color: Color = INK,
        align: Literal["left", "center", "right"] = "center",
        alpha: float = 1.0,
        layer: float = ON_TOP,
        once: bool = False,
    ) -> Drawn:
        """Write a line of text; it is seen while its place is.

        Args:
            x: Its place [m].
            y: Its middle [m].
            words: The text, one line.
            size: Its size [point], from 1 to 200.
            color: Its colour.
            align: Which part of it is at ``x``: ``left``, ``center`` or ``right``.
            alpha: Its opacity.
            layer: Its layer; by default it covers everything.
            once: Only for the next picture.

        Raises:
            ValueError: A place that is no number, more than one line, or no such size, colour, part, opacity or layer.
        """
        if align not in ("left", "center", "right"):
            raise ValueError(f"align is 'left', 'center' or 'right', got {align!r}")
        across, up = (looks.number(name, value, least=-np.inf) for name, value in (("x", x), ("y", y)))
        ink, high = strokes.StrokeInk.of(color, alpha, layer), looks.number("size", size, least=1.0, most=LARGEST_TEXT)
        mark = TextMark(across, up, _line(words), ink.color, ink.alpha, high, align, ink.layer)
        return self.add([mark] if words.strip() else [], once)

    def title(self, words: str | None) -> None:
        """Write a title above the world, in place of its name, status and time, until the next reset.

        A world with ``plot: {show_title: false}`` has no room for one.

        Args:
            words: The title, one line; None for what the file says.

        Raises:
            ValueError: It has more than one line.
        """
        self._title = None if words is None else _line(words)
        self._changed()

    def remove(self, drawn: Drawn) -> None:
        """Take away what a call has drawn; nothing happens where it is gone already."""
        gone = set(map(id, drawn.marks))
        self._marks = [(mark, age) for mark, age in self._marks if id(mark) not in gone]
        self._changed()

    def clear(self) -> None:
        """Take away all marks, and the title."""
        self._marks, self._title = [], None
        self._changed()

    def add(self, marks: Sequence[Mark], once: bool) -> Drawn:
        """Draw marks that are made already.

        Args:
            marks: The marks.
            once: Only for the next picture.
        """
        if marks:
            self._marks += [(mark, FRESH if once else STAYS) for mark in marks]
            self._changed()
        return Drawn(self, tuple(marks))

    def _changed(self) -> None:
        self._overlays.clear()
        self._is_changed = True

    @property
    def is_changed(self) -> bool:
        """Somebody drew or removed something since ``keep``."""
        return self._is_changed

    def keep(self) -> Overlay:
        """Return what a film shows of the present moment."""
        self._is_changed = False
        return self.overlay(old=False)

    def overlay(self, *, old: bool = True) -> Overlay:
        """Return what is drawn now, the same object until that changes.

        Args:
            old: With marks of an earlier moment that are still to be rendered.
        """
        found = self._overlays.get(old)
        if found is None:
            marks = tuple(mark for mark, age in self._marks if old or age != OLD)
            found = NOTHING if not marks and self._title is None else Overlay(marks, self._title)
            self._overlays[old] = found
        return found

    @property
    def has_old(self) -> bool:
        """There are marks of an earlier moment that are still to be rendered."""
        return any(age == OLD for _, age in self._marks)

    def shown(self) -> None:
        """Remove the marks that were drawn for one picture, after it was shown."""
        self._age({STAYS: STAYS})

    def grow_old(self) -> None:
        """Note that a moment has passed without a rendering: marks for one picture wait for one more."""
        self._age({STAYS: STAYS, FRESH: OLD})

    def _age(self, later: Mapping[int, int]) -> None:
        """Give marks another age, and forget those that have none."""
        if any(age != STAYS for _, age in self._marks):
            self._marks = [(mark, later[age]) for mark, age in self._marks if age in later]
            self._overlays.clear()

    def begin(self) -> None:
        """Begin an episode: what was drawn for one picture, and the title, are gone."""
        self.shown()
        if self._title is not None:
            self._title = None
            self._overlays.clear()


def _line(words: str) -> str:
    if not isinstance(words, str) or len(words.splitlines()) > 1:
        raise ValueError(f"one line of text, got {words!r}")
    return words.rstrip("\r\n")
