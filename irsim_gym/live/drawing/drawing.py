"""Marks drawn over a world, and how long each stays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.live.drawing import arrows, looks, places, strokes
from irsim_gym.live.drawing.looks import Color, Colors
from irsim_gym.simulator.readings.marks import NOTHING, ON_TOP, LineMark, Mark, Overlay, TextMark

PATH, ARROW, INK = "#0072B2", "black", "#1F2933"
LINE_LAYER, GROUND_LAYER = 2.0, 1.0
LARGEST_TEXT = 200.0
"""Size of the largest text [point]."""
STAYS, FRESH, OLD = range(3)
"""Ages of marks: permanent, for one picture, and for one picture but not rendered at their own moment."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The marks that one call has drawn.

    Attributes:
        drawing: The drawing that holds them.
        marks: The marks.
    """

    drawing: Drawing
    marks: tuple[Mark, ...]

    def remove(self) -> None:
        """Remove the marks, if they are still there."""
        self.drawing.remove(self)


class Drawing:
    """Marks over a world: lines, points, areas, arrows, texts. They appear in pictures and change nothing else.

    ``render``, windows, saved figures, films and replays show them, inside the world's rectangle. A mark stays until it
    is removed, also after a reset. With ``once=True`` only the next picture that ``render`` draws shows it; if nobody
    renders, a film shows it at the moment of drawing. Empty lists draw nothing.

    Points are rows ``x, y`` [m], as a list or an array of shape ``(n, 2)``; more columns are ignored. A point that is
    not finite, or 1e9 m away, is left out and interrupts a line. Colours are those of matplotlib: ``"red"``, ``"C0"``,
    ``"#d62728"``, ``(0.8, 0.1, 0.1)``. Widths and sizes are in typographic points, which do not scale with the world.
    Marks in a higher ``layer`` cover lower ones: obstacles are in layer 1, robots in layer 3.
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
            format: Colour, marker and line style in matplotlib's notation, such as ``"g--"`` or ``"ro"``.
            color: Colour (default: that of the format, or else blue).
            width: Width [point].
            alpha: Opacity.
            layer: Layer.
            once: Whether only the next picture shows it.

        Raises:
            ValueError: The points, format, colour, width, opacity or layer are not valid.
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
            color: Colour, or a list with a colour for each point (default: pink).
            size: Diameter [point].
            marker: Marker, one of ``o . , s ^ v < > D d p h * | _ + x``.
            alpha: Opacity.
            layer: Layer.
            once: Whether only the next picture shows it.

        Raises:
            ValueError: The points, colour, size, marker, opacity or layer are not valid.
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
            points: At least three corners [m]; the last one need not repeat the first.
            color: Colour of the edge, or None for no edge.
            fill: Colour of the area, or None for no area.
            width: Width of the edge [point].
            style: Style of the edge: ``-``, ``--``, ``-.`` or ``:``.
            alpha: Opacity of both.
            layer: Layer.
            once: Whether only the next picture shows it.

        Raises:
            ValueError: The points, colour, width, style, opacity or layer are not valid.
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
            tails: Start of each arrow [m].
            vectors: A row ``u, v`` for each arrow: its direction, and its length [m] unless ``length`` is given. A
                vector of length 0 has no arrow.
            length: Length of all arrows [m].
            width: Width of the shafts [m] (default: 1/16 of the mean length). Heads are three times as wide.
            color: Colour.
            alpha: Opacity.
            layer: Layer.
            once: Whether only the next picture shows it.

        Raises:
            ValueError: The numbers of tails and vectors differ, or a length, width, colour, opacity or layer is wrong.
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
        """Write a line of text. It is visible where its position is inside the picture.

        Args:
            x: Horizontal position [m].
            y: Vertical position of its middle [m].
            words: The text, one line.
            size: Size [point], from 1 to 200.
            color: Colour.
            align: The part of the text that is at ``x``: ``left``, ``center`` or ``right``.
            alpha: Opacity.
            layer: Layer (default: above everything).
            once: Whether only the next picture shows it.

        Raises:
            ValueError: The position, size, colour, ``align``, opacity or layer is wrong, or there are several lines.
        """
        if align not in ("left", "center", "right"):
            raise ValueError(f"align is 'left', 'center' or 'right', got {align!r}")
        across, up = (looks.number(name, value, least=-np.inf) for name, value in (("x", x), ("y", y)))
        ink, high = strokes.StrokeInk.of(color, alpha, layer), looks.number("size", size, least=1.0, most=LARGEST_TEXT)
        mark = TextMark(across, up, _line(words), ink.color, ink.alpha, high, align, ink.layer)
        return self.add([mark] if words.strip() else [], once)

    def title(self, words: str | None) -> None:
        """Write a title above the world, instead of its name, status and time, until the next reset.

        With ``plot: {show_title: false}`` it is not shown.

        Args:
            words: The title, one line, or None for the usual one.

        Raises:
            ValueError: The title has more than one line.
        """
        self._title = None if words is None else _line(words)
        self._changed()

    def remove(self, drawn: Drawn) -> None:
        """Remove the marks of one call, if they are still there."""
        gone = set(map(id, drawn.marks))
        self._marks = [(mark, age) for mark, age in self._marks if id(mark) not in gone]
        self._changed()

    def clear(self) -> None:
        """Remove all marks, and the title."""
        self._marks, self._title = [], None
        self._changed()

    def add(self, marks: Sequence[Mark], once: bool) -> Drawn:
        """Add marks.

        Args:
            marks: The marks.
            once: Whether only the next picture shows it.
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
        """Whether marks were drawn or removed since ``keep``."""
        return self._is_changed

    def keep(self) -> Overlay:
        """Return the marks that a film shows at the present moment."""
        self._is_changed = False
        return self.overlay(old=False)

    def overlay(self, *, old: bool = True) -> Overlay:
        """Return the present marks. The object stays the same until they change.

        Args:
            old: Whether to include marks of an earlier moment that are still to be rendered.
        """
        overlay = self._overlays.get(old)
        if overlay is None:
            marks = tuple(mark for mark, age in self._marks if old or age != OLD)
            overlay = NOTHING if not marks and self._title is None else Overlay(marks, self._title)
            self._overlays[old] = overlay
        return overlay

    @property
    def has_old(self) -> bool:
        """Whether marks of an earlier moment are still to be rendered."""
        return any(age == OLD for _, age in self._marks)

    def shown(self) -> None:
        """Remove marks for one picture, after it was shown."""
        self._age({STAYS: STAYS})

    def grow_old(self) -> None:
        """Note that a moment has passed without rendering: marks for one picture wait for the next one."""
        self._age({STAYS: STAYS, FRESH: OLD})

    def _age(self, later: Mapping[int, int]) -> None:
        """Change the age of marks, and remove those whose age is not in ``later``."""
        if any(age != STAYS for _, age in self._marks):
            self._marks = [(mark, later[age]) for mark, age in self._marks if age in later]
            self._overlays.clear()

    def begin(self) -> None:
        """Begin an episode: remove marks for one picture, and the title."""
        self.shown()
        if self._title is not None:
            self._title = None
            self._overlays.clear()


def _line(words: str) -> str:
    if not isinstance(words, str) or len(words.splitlines()) > 1:
        raise ValueError(f"one line of text, got {words!r}")
    return words.rstrip("\r\n")
