"""Makes the marks of drawings, and checks their style."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self, cast

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.drawing import looks, places
from irsim_gym.live.drawing.looks import Color, Colors
from irsim_gym.simulator.readings.marks import LineMark, Mark, PointsMark

POINTS = "#CC79A7"
MARKER_SIZE, MARKER_WIDTH = 6.0, 1.5
"""Size of markers along a line, and width of the lines of crosses [point]."""


@dataclass(frozen=True)
class StrokeInk:
    """Colour, opacity and layer of marks."""

    color: str
    alpha: float
    layer: float

    @classmethod
    def of(cls, color: Color | None, alpha: object, layer: object) -> Self:
        """Return these, checked.

        Raises:
            ValueError: There is no such colour, opacity or layer.
        """
        bounded = looks.number("alpha", alpha, most=1.0), looks.number("layer", layer, least=-np.inf)
        return cls("none" if color is None else looks.color(color), *bounded)

    @property
    def is_seen(self) -> bool:
        """There is a colour."""
        return self.color.lower() != "none"


def line(points: Floats, look: looks.Format, ink: StrokeInk, width: object, size: object = MARKER_SIZE) -> list[Mark]:
    """Return a line through points, with markers at them.

    Args:
        points: The points [m], shape ``(n, d)``. Points that are not finite interrupt the line.
        look: Line style and marker.
        ink: Colour, opacity and layer.
        width: Width of the line [point].
        size: Size of the markers [point].

    Raises:
        ValueError: There is no such width or size.
    """
    thick, large = looks.number("width", width), looks.number("size", size)
    marks: list[Mark] = []
    if look.style:
        marks += [
            LineMark(way, ink.color, ink.alpha, thick, look.style, False, "", ink.layer)
            for way in places.runs(points)
            if len(way) > 1
        ]
    return marks + (forms(points, ink, look.marker, large) if look.marker else [])


def forms(points: Floats, ink: StrokeInk, marker: str, size: float, width: float = MARKER_WIDTH) -> list[Mark]:
    """Return markers at points [m], shape ``(n, d)``; an empty result without points.

    Args:
        points: The points.
        ink: Colour, opacity and layer.
        marker: Marker of the points.
        size: Size of the markers [point].
        width: Line width of markers that consist of lines [point].
    """
    chosen = places.finite(points)
    if not len(chosen):
        return []
    stroke = width if marker in looks.STROKES else 0.0
    if marker in looks.DISCS:
        return [PointsMark(chosen, ink.color, ink.alpha, looks.DISCS[marker] * size, (), stroke, ink.layer)]
    from irsim_gym.rendering.looks.markers import marker_form

    return [PointsMark(chosen, ink.color, ink.alpha, size, marker_form(marker), stroke, ink.layer)]


def points(
    rows: Floats, color: Colors | None, marker: str, size: object, width: object, alpha: object, layer: object
) -> list[Mark]:
    """Return markers at points, in one colour or in one for each point.

    Raises:
        ValueError: There is no such look.
    """
    form = looks.marker(marker) or "o"
    large, thick = looks.number("size", size), looks.number("width", width)
    inks = [StrokeInk.of(one, alpha, layer) for one in _colors(color, len(rows))]
    if len(inks) == 1:
        return forms(rows, inks[0], form, large, thick)
    numbers = {ink: np.array([one == ink for one in inks]) for ink in dict.fromkeys(inks)}
    return [mark for ink, chosen in numbers.items() for mark in forms(rows[chosen], ink, form, large, thick)]


def area(corners: Floats, edge: StrokeInk, fill: Color | None, style: str, width: object) -> list[Mark]:
    """Return a polygon; an empty result without corners.

    Args:
        corners: Its corners [m], shape ``(n, d)``.
        edge: Colour of its edge.
        fill: Colour of its area; None for none.
        style: Style of its edge, as ``LineMark`` has it; empty for no edge.
        width: Width of its edge [point].

    Raises:
        ValueError: There are fewer than three corners, or there is no such colour or width.
    """
    found, thick = places.finite(corners), looks.number("width", width)
    inside = "none" if fill is None else looks.color(fill)
    if 0 < len(found) < 3:
        raise ValueError(f"a polygon has at least 3 corners, got {len(found)}")
    if not len(found):
        return []
    thick = thick if style and edge.is_seen else 0.0
    filled = "" if inside.lower() == "none" else inside
    return [LineMark(found, edge.color, edge.alpha, thick, style or "solid", True, filled, edge.layer)]


def _colors(color: Colors | None, count: int) -> Sequence[Color]:
    """Return one colour, or one for each point."""
    if color is None:
        return [POINTS]
    is_list = isinstance(color, list | tuple | np.ndarray) and len(color) > 0
    if not is_list or isinstance(color[0], int | float | np.number):
        return [cast(Color, color)]
    if len(color) != count:
        raise ValueError(f"one colour, or one for each of {count} points, got {len(color)}")
    return list(color)
