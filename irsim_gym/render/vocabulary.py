"""What everything is drawn with: what covers what, and the pens, shapes and words that stand for a scene's views.

Frames and replay pages read this table alike: a page gets ranks, pens and shapes as JSON (`replay_items`), so that a
figure that is added here needs no JavaScript. Widths and type sizes are points of the figure unless they say [m].
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.raster.figures import APART, FADE_STEPS, FAINTEST
from irsim_gym.raster.play import LABEL_GAP
from irsim_gym.render import theme
from irsim_gym.render.scene import GoalView
from irsim_gym.render.styles import GROUND, TOP, BodyStyle, ScanStyle, faded
from irsim_gym.world.marks import LineMark, PointsMark

HALF_A_WALL = 1.1
"""Half the width of a wall's line: one along the world's border is drawn whole."""
LINE_STYLES = ("solid", "dashed", "dashdot", "dotted")
LABEL_HEIGHT, LETTER_WIDTH = 1.3, 0.7
"""Height of a label and width of one of its letters, in type sizes."""
THINNEST_BAND = 0.3
"""The least width of a trajectory with a width in metres."""


class Rank(NamedTuple):
    """How a kind of thing is drawn.

    Attributes:
        reach: How far it may reach over the world's border; None for not cut there.
        switch: Name of the page's switch that shows it; empty for none.
    """

    reach: float | None = None
    switch: str = ""


RANKS = {
    "map": Rank(),
    "touch": Rank(),
    "shadows": Rank(HALF_A_WALL),
    "fixed": Rank(HALF_A_WALL),
    "fog": Rank(),
    "ghosts": Rank(0.0, "paths"),
    "scans": Rank(0.0, "scans"),
    "fields": Rank(0.0),
    "goals": Rank(),
    "waypoints": Rank(),
    "flags": Rank(),
    "paths": Rank(0.0, "paths"),
    "bodies": Rank(HALF_A_WALL),
    "headings": Rank(HALF_A_WALL),
    "hits": Rank(0.0, "scans"),
    "impacts": Rank(HALF_A_WALL),
    "labels": Rank(),
    "names": Rank(None, "names"),
    "marks": Rank(0.0),
    "words": Rank(),
    "frame": Rank(),
}
"""What is drawn, by name; within a layer, later ones cover earlier ones."""
CONSTANTS = {
    "ranks": {name: rank._asdict() for name, rank in RANKS.items()},
    "flag": theme.FLAG,
    "label": {"gap": LABEL_GAP, "height": LABEL_HEIGHT, "letter": LETTER_WIDTH},
    "fade": {"steps": FADE_STEPS, "faintest": FAINTEST, "apart": APART},
    "thinnest": THINNEST_BAND,
}
"""What the page's script has to know beside what it draws."""


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
        line: Line style of the edge, one of ``LINE_STYLES``.
        in_metres: The width is in metres.
        cap: How open lines end, ``round`` or ``butt``.
        filled_radius: The fill of a larger disc gets fainter with its area, so that many do not hide each other; 0 for
            a fill that stays as it is.
    """

    fill: Ink | None = None
    edge: Ink | None = None
    width: float = 0.0
    line: str = "solid"
    in_metres: bool = False
    cap: str = "round"
    filled_radius: float = 0.0


@dataclass(frozen=True, eq=False)
class Shape:
    """An outline in a frame of its own.

    Attributes:
        chains: Chains of vertices [m], each of shape ``(n, 2)``; closed ones repeat the first vertex.
        offsets: What is added to the vertices of each chain [point]; none for chains in metres alone.
        least: A vertex that is not at the origin is at least this far away before its offset is added [point].
        discs: x, y, radius of discs [m], shape ``(n, 3)``.
        sector: Width [rad] and radius [m] of a sector that looks ahead from the origin, or None.
        dot: Radius of a disc about the origin [point].
    """

    chains: tuple[Floats, ...] = ()
    offsets: tuple[Floats, ...] = ()
    least: float = 0.0
    discs: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    sector: tuple[float, float] | None = None
    dot: float = 0.0


class Figure(NamedTuple):
    """A shape at some places.

    Attributes:
        rank: One of ``RANKS``.
        layer: Its layer.
        pen: How it is drawn.
        shape: What is drawn.
        places: x, y [m] and, where it is turned, heading [rad] of each place, shape ``(n, 2)`` or ``(n, 3)``; None for
            the origin.
    """

    rank: str
    layer: float
    pen: Pen
    shape: Shape
    places: Floats | None = None


class Beams(NamedTuple):
    """A way to draw what a range sensor sees.

    Attributes:
        rank: One of ``RANKS``.
        layer: Its layer.
        form: ``area`` between the beams, ``rays``, or ``dots`` at their ends.
        which: ``all`` beams, those that end on something (``hits``), those measured (``valid``), or the others
            (``free``).
        pen: How they are drawn.
        tinted: With this opacity they have the colours of their radial velocities; None for the pen's colours.
        radius: Radius of the dots.
    """

    rank: str
    layer: float
    form: str
    which: str
    pen: Pen
    tinted: float | None = None
    radius: float = 0.0


SHADOWS = tuple(
    (shift, Pen(Ink(theme.SHADOW, opacity), Ink(theme.SHADOW, 0.4 * opacity), 1.5))
    for shift, opacity in theme.SHADOWS
)
"""Shadows of fixed bodies: how far they lie to the right and below, and how they are drawn."""
IMPACT = (Pen(edge=Ink(theme.IMPACT, 0.25), width=5.0), Pen(edge=Ink(theme.IMPACT), width=1.8))
"""The edge of bodies that collide."""
POLE = Shape(offsets=(np.array(theme.FLAG_POLE),))
PENNANT = Shape(offsets=(np.array([*theme.FLAG_PENNANT, theme.FLAG_PENNANT[0]]),))
WAYPOINT = Shape(dot=2.25)


def footprint(style: BodyStyle, *, filled: bool, parts: int = 1) -> tuple[Pen, ...]:
    """Return how a footprint is drawn, one pen after the other; one of several parts has no edges where they overlap."""
    fill = Ink(style.colour, style.alpha)
    edge = Ink(style.colour, style.alpha, 0.68 if filled else 1.0)
    if style.edge_colour is not None:
        edge = Ink(style.edge_colour, style.alpha)
    if not filled:
        return (Pen(None, edge, style.wall_width, style.line_style),)
    if parts > 1 and style.alpha == 1.0:
        return Pen(None, edge, 2.0 * style.line_width, style.line_style), Pen(fill)
    return (Pen(fill, edge, style.line_width, style.line_style),)


def heading(style: BodyStyle) -> Pen:
    """Return how the mark of a body's heading is drawn."""
    return Pen(Ink(style.arrow_colour, style.arrow_alpha))


def field_of_view(style: BodyStyle) -> Pen:
    """Return how a field of view is drawn."""
    return Pen(Ink(style.field_colour, style.field_alpha), Ink(style.field_edge_colour, style.field_alpha), 0.9)


def trajectory(style: BodyStyle) -> Pen:
    """Return how a trajectory is drawn: one without a width in metres is thin, and fades towards its beginning."""
    ink, width = Ink(style.trajectory_colour, style.trajectory_alpha), style.trajectory_width
    return Pen(None, ink, width or theme.PATH_WIDTH, style.trajectory_style, width is not None, "butt")


def goal(view: GoalView) -> Iterator[Figure]:
    """Yield a goal: the circle of its tolerance, an arrow where a heading counts, later goals, and a flag."""
    style, foot = view.style, np.array([[view.x, view.y]])
    inks = {share: Ink(style.goal_colour, share * style.goal_alpha) for share in (0.45, 0.9, 1.0)}
    full = theme.REACHED_FILL if view.arrived else theme.GOAL_FILL
    fill = Ink(style.goal_colour, full * style.goal_alpha)
    circle = Shape(discs=np.array([[0.0, 0.0, view.tolerance]]))
    yield Figure("goals", style.goal_order, Pen(fill, inks[0.9], 1.1, filled_radius=theme.FILLED_RADIUS), circle, foot)
    if not math.isnan(view.heading):
        place = np.array([[view.x, view.y, view.heading]])
        yield Figure("goals", style.goal_order, Pen(inks[0.9]), goal_arrow(view.tolerance), place)
    if len(view.later):
        yield Figure("waypoints", style.goal_order, Pen(inks[0.45]), WAYPOINT, view.later)
    yield Figure("flags", style.goal_order, Pen(None, inks[1.0], 1.3, cap="butt"), POLE, foot)
    yield Figure("flags", style.goal_order, Pen(inks[1.0]), PENNANT, foot)


def goal_arrow(radius: float) -> Shape:
    """Return the arrow at a goal with a circle of this radius [m], where its shaft ends; see ``theme.GOAL_ARROW``."""
    least, head, wide, thin = theme.GOAL_ARROW
    reach = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]) * max(radius, 1e-3)
    sides = [(0.0, thin), (0.0, thin), (0.0, wide), (head, 0.0), (0.0, -wide), (0.0, -thin), (0.0, -thin), (0.0, thin)]
    return Shape((np.column_stack([reach, np.zeros(8)]),), (np.array(sides),), least)


def scan(style: ScanStyle) -> Iterator[Beams]:
    """Yield what is drawn of a scan."""
    speed = style.velocity
    if speed is not None and speed.coloured:
        free = Pen(edge=Ink(speed.free_colour, speed.free_alpha), width=speed.free_width, cap="butt")
        yield Beams("scans", GROUND, "rays", "free", free)
        yield Beams("scans", GROUND, "rays", "valid", Pen(width=speed.width, cap="butt"), style.alpha)
    else:
        area, rays = (Ink(style.colour, min(share * style.alpha, 1.0)) for share in (0.22, 0.9))
        yield Beams("scans", GROUND, "area", "all", Pen(area))
        yield Beams("scans", GROUND, "rays", "all", Pen(edge=rays, width=0.45, cap="butt"))
    if speed is None:
        yield Beams("hits", TOP, "dots", "hits", Pen(Ink(style.colour, min(3.0 * style.alpha, 1.0))), radius=1.3)
    elif speed.mark_size > 0.0:
        rim = Pen(edge=Ink(speed.mark_edge_colour), width=speed.mark_edge_width)
        yield Beams("hits", TOP, "dots", "valid", rim, 1.0, 0.5 * math.sqrt(speed.mark_size))


def mark(drawn: LineMark | PointsMark) -> Figure:
    """Return the figure of a mark that somebody drew over the world."""
    ink = Ink(*faded(drawn.color, drawn.alpha))
    if isinstance(drawn, LineMark):
        fill = Ink(*faded(drawn.fill, drawn.alpha)) if drawn.fill else None
        points = np.concatenate([drawn.points, drawn.points[:1]]) if drawn.closed else drawn.points
        pen = Pen(fill, ink, drawn.width, drawn.style, cap="butt")
        return Figure("marks", drawn.layer, pen, Shape((points,)))
    if not drawn.form:
        return Figure("marks", drawn.layer, Pen(ink), Shape(dot=0.5 * drawn.size), drawn.points)
    pen = Pen(edge=ink, width=drawn.width, cap="butt") if drawn.width else Pen(ink)
    return Figure("marks", drawn.layer, pen, Shape(offsets=tuple(drawn.size * p for p in drawn.form)), drawn.points)
