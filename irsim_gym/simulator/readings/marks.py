"""Drawings over a world, as plain data; they never change what happens in it."""

from dataclasses import dataclass

from irsim_gym.base.arraytypes import Floats

ON_TOP = 1e9
"""The layer that covers everything."""


@dataclass(frozen=True, eq=False)
class LineMark:
    """A line through points, or an area.

    Attributes:
        points: The points, all finite [m], shape ``(n, 2)``.
        color: Colour of the line, as matplotlib names colours.
        alpha: Opacity of line and area.
        width: Width of the line [point]; 0 for none.
        style: ``solid``, ``dashed``, ``dashdot`` or ``dotted``.
        closed: The line goes back to its first point.
        fill: Colour of the area inside; empty for none.
        layer: Marks with a higher number cover those with a lower one; obstacles are in 1, robots in 3.
    """

    points: Floats
    color: str
    alpha: float
    width: float
    style: str
    closed: bool
    fill: str
    layer: float


@dataclass(frozen=True, eq=False)
class PointsMark:
    """Marks of one form and size at points.

    Attributes:
        points: The points, all finite [m], shape ``(n, 2)``.
        color: Their colour.
        alpha: Their opacity.
        size: Diameter, or side of the square around them [point].
        form: Corners of the form in a square with the side 1 about the origin, one array ``(k, 2)`` for each part; a
            disc where there is none.
        width: Width of the form's lines [point]; 0 for a form that is filled.
        layer: As of ``LineMark``.
    """

    points: Floats
    color: str
    alpha: float
    size: float
    form: tuple[Floats, ...]
    width: float
    layer: float


@dataclass(frozen=True, eq=False)
class TextMark:
    """A line of text.

    Attributes:
        x: Abscissa of its place [m].
        y: Ordinate of its middle [m].
        text: The words.
        color: Their colour.
        alpha: Their opacity.
        size: Their size [point].
        align: Which part of it is at ``x``: ``left``, ``center`` or ``right``.
        layer: As of ``LineMark``.
    """

    x: float
    y: float
    text: str
    color: str
    alpha: float
    size: float
    align: str
    layer: float


Mark = LineMark | PointsMark | TextMark


@dataclass(frozen=True, eq=False)
class Overlay:
    """All that is drawn over one world.

    Attributes:
        marks: The marks, in the order in which they were drawn.
        title: What is written above the world in place of name, status and time; None for these.
    """

    marks: tuple[Mark, ...] = ()
    title: str | None = None


NOTHING = Overlay()
