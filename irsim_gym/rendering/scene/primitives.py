"""The primitives that make up pictures of a world, and their pens and shapes.

The script of a replay page selects a primitive by its class name and reads its fields by name. Widths, type sizes and
shifts are typographic points unless marked as [m].
"""

from typing import NamedTuple

from irsim_gym.base.arraytypes import Bytes, Floats, Ints


class Ink(NamedTuple):
    """A colour.

    Attributes:
        colour: A name as in matplotlib; an opacity in it is ignored.
        opacity: Its opacity.
        brightness: Factor of its red, green and blue.
    """

    colour: str
    opacity: float = 1.0
    brightness: float = 1.0


class Pen(NamedTuple):
    """The style of a shape, whose area is drawn before its edge.

    Attributes:
        fill: Colour of its area; None for none.
        edge: Colour of its edge; None for none.
        width: Width of the edge; 0 for none.
        line: Line style of the edge: ``solid``, ``dashed``, ``dashdot`` or ``dotted``.
        in_metres: Whether the width is in metres.
        cap: Ends of open lines, ``round`` or ``butt``.
        filled_radius: Radius above which the fill of a disc gets fainter with its area; 0 for a constant fill.
    """

    fill: Ink | None = None
    edge: Ink | None = None
    width: float = 0.0
    line: str = "solid"
    in_metres: bool = False
    cap: str = "round"
    filled_radius: float = 0.0


class Shape(NamedTuple):
    """An outline in its own frame.

    Attributes:
        chains: Chains of vertices [m], each of shape ``(n, 2)``; closed ones repeat the first vertex.
        offsets: Offsets of the vertices of each chain [point]; empty for none.
        least: Minimum distance from the origin of vertices other than the origin, before the offset is added [point].
        discs: x, y, radius of discs [m], shape ``(n, 3)``.
        sector: Width [rad] and radius [m] of a sector at the origin, centred on the x axis.
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
        rank: Its rank, see ``vocabulary.RANKS``.
        layer: Its layer.
        pen: The pen.
        shape: The shape.
        places: x, y [m] and optionally heading [rad] of each place, shape ``(n, 2)`` or ``(n, 3)``; None for its body's
            pose, or the origin.
        shift: Shift to the right and downwards.
        turned: Whether it points along its body's displayed heading.
        past: For trails, the interval [steps] and the number of the latest past poses at which it is drawn; 0 for all.
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
        rank: Its rank.
        layer: Its layer.
        pixels: Its pixels, see ``scene.ImageView``.
        box: x_min, y_min, x_max, y_max [m].
        alpha: Its opacity.
    """

    rank: str
    layer: float
    pixels: Bytes
    box: tuple[float, ...]
    alpha: float


class Way(NamedTuple):
    """The path of a body; a path with a width in points fades towards its start.

    Attributes:
        rank: Its rank.
        layer: Its layer.
        pen: The pen.
        length: Number of the latest positions to draw; 0 for all.
    """

    rank: str
    layer: float
    pen: Pen
    length: int = 0


class SpeedInks(NamedTuple):
    """The colours of radial velocities: that of the sign, mixed with that of rest below the full speed [m/s]."""

    rest: Ink
    away: Ink
    nearer: Ink
    full_speed: float


class Beams(NamedTuple):
    """The beams of a range sensor.

    Attributes:
        rank: Their rank.
        layer: Their layer.
        form: ``area`` between the beams, ``rays``, or ``dots`` at their ends.
        which: ``all`` beams, those that hit something (``hits``), those with a valid reading (``valid``), or the others
            (``free``).
        pen: The pen.
        every: Interval of drawn beams: every n-th.
        radius: Radius of the dots.
        speeds: Colours of radial velocities, which replace that of the pen; None to use the pen.
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
        rank: Its rank.
        layer: Its layer.
        text: The words.
        size: Type size.
        ink: Colour.
        places: x, y [m], shape ``(1, 2)``; None for above its body, or below it if the text would cover a goal's flag.
        offset: Offset from its body's origin [m]; None for above the body.
        drop: Shift downwards from its place.
        align: Horizontal alignment at its place: ``left``, ``center`` or ``right``.
        level: Vertical alignment at its place: ``bottom`` or ``middle``.
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
    """The fog over unseen cells.

    Attributes:
        rank: Its rank.
        layer: Its layer.
        ink: Its colour.
    """

    rank: str
    layer: float
    ink: Ink


Primitive = Figure | Picture | Way | Beams | Words | Cover
