"""The primitives of which pictures of a world consist, and the pens and shapes of which these consist.

A replay page's script draws each primitive by its class name and reads its fields by their names. Widths, type sizes
and shifts are points of the figure unless they say [m].
"""

from __future__ import annotations

from typing import NamedTuple

from irsim_gym.arraytypes import Bytes, Floats, Ints


class Ink(NamedTuple):
    """A colour.

    Attributes:
        colour: Its name, as matplotlib names colours; an opacity in it does not count.
        opacity: Its opacity.
        brightness: Share of its red, green and blue.
    """

    colour: str
    opacity: float = 1.0
    brightness: float = 1.0


class Pen(NamedTuple):
    """How a shape is drawn: its area first, then its edge.

    Attributes:
        fill: Colour of its area; None for none.
        edge: Colour of its edge; None for none.
        width: Width of the edge; 0 for none.
        line: Line style of the edge: ``solid``, ``dashed``, ``dashdot`` or ``dotted``.
        in_metres: The width is in metres.
        cap: How open lines end, ``round`` or ``butt``.
        filled_radius: The fill of a larger disc gets fainter with its area; 0 for a fill that stays as it is.
    """

    fill: Ink | None = None
    edge: Ink | None = None
    width: float = 0.0
    line: str = "solid"
    in_metres: bool = False
    cap: str = "round"
    filled_radius: float = 0.0


class Shape(NamedTuple):
    """An outline in a frame of its own.

    Attributes:
        chains: Chains of vertices [m], each of shape ``(n, 2)``; closed ones repeat the first vertex.
        offsets: What is added to the vertices of each chain [point]; empty for chains in metres alone.
        least: A vertex that is not at the origin is at least this far away before its offset is added [point].
        discs: x, y, radius of discs [m], shape ``(n, 3)``.
        sector: Width [rad] and radius [m] of a sector that looks ahead from the origin.
        dot: Radius of a disc about the origin [point].
        boxes: x_min, y_min, x_max, y_max of rectangles along the axes [cell], shape ``(n, 4)``.
        cell: x, y of the first cell's corner, and width and height of a cell [m].
    """

    chains: tuple[Floats, ...] = ()
    offsets: tuple[Floats, ...] = ()
    least: float = 0.0
    discs: Floats | None = None
    sector: tuple[float, float] | None = None
    dot: float = 0.0
    boxes: Ints | None = None
    cell: tuple[float, float, float, float] | None = None


class Figure(NamedTuple):
    """A shape.

    Attributes:
        rank: What it belongs to, see ``vocabulary.RANKS``.
        layer: Its layer.
        pen: How it is drawn.
        shape: What is drawn.
        places: x, y [m] and, where it is turned, heading [rad] of each place, shape ``(n, 2)`` or ``(n, 3)``; None for
            its body's pose, or the origin.
        shift: How far it lies to the right and below.
        turned: It points where its body is seen to head.
        past: It stands where its body was at every n-th step, at so many of the latest; 0 for all.
    """

    rank: str
    layer: float
    pen: Pen
    shape: Shape
    places: Floats | None = None
    shift: float = 0.0
    turned: bool = False
    past: tuple[int, int] | None = None


class Picture(NamedTuple):
    """An image in its body's frame.

    Attributes:
        rank: What it belongs to.
        layer: Its layer.
        pixels: As of a ``scene.ImageView``.
        box: x_min, y_min, x_max, y_max [m].
        alpha: Its opacity.
    """

    rank: str
    layer: float
    pixels: Bytes
    box: tuple[float, ...]
    alpha: float


class Way(NamedTuple):
    """Where a body has been; one with a width in points fades towards its beginning.

    Attributes:
        rank: What it belongs to.
        layer: Its layer.
        pen: How it is drawn.
        length: So many of the latest positions are drawn; 0 for all.
    """

    rank: str
    layer: float
    pen: Pen
    length: int = 0


class SpeedInks(NamedTuple):
    """The colours of radial velocities: the sign's, mixed with that of rest below the full speed [m/s]."""

    rest: Ink
    away: Ink
    nearer: Ink
    full_speed: float


class Beams(NamedTuple):
    """What a range sensor sees.

    Attributes:
        rank: What it belongs to.
        layer: Its layer.
        form: ``area`` between the beams, ``rays``, or ``dots`` at their ends.
        which: ``all`` beams, those that end on something (``hits``), those measured (``valid``), or the others
            (``free``).
        pen: How they are drawn.
        every: Of the beams every n-th is drawn.
        radius: Radius of the dots.
        speeds: The colours of their radial velocities, in place of the pen's; None for none.
    """

    rank: str
    layer: float
    form: str
    which: str
    pen: Pen
    every: int = 1
    radius: float = 0.0
    speeds: SpeedInks | None = None


class Words(NamedTuple):
    """A text.

    Attributes:
        rank: What it belongs to.
        layer: Its layer.
        text: The words.
        size: Their size.
        ink: Their colour.
        places: x, y [m], shape ``(1, 2)``; None for above its body, or below where it would stand on a goal's flag.
        offset: Where it stands from its body's origin [m], in place of above it.
        drop: How far it lies below its place.
        align: What of it is at its place: ``left``, ``center`` or ``right``.
        level: What of it is at its place: ``bottom`` or ``middle``.
    """

    rank: str
    layer: float
    text: str
    size: float
    ink: Ink
    places: Floats | None = None
    offset: tuple[float, float] | None = None
    drop: float = 0.0
    align: str = "center"
    level: str = "bottom"


class Cover(NamedTuple):
    """The fog over what nobody has seen.

    Attributes:
        rank: What it belongs to.
        layer: Its layer.
        ink: Its colour.
    """

    rank: str
    layer: float
    ink: Ink


Primitive = Figure | Picture | Way | Beams | Words | Cover
