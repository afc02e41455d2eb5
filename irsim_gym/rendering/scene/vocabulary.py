"""The drawing vocabulary: the drawing order, and the primitives of each view of a scene.

All renderers of scenes use it. A replay page gets the primitives as JSON (`replay_items`), so that new views made of
known primitives need no JavaScript.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.styles import GROUND, TOP, BodyStyle, ScanStyle, faded
from irsim_gym.rendering.raster.beams import MOST_BEAMS
from irsim_gym.rendering.raster.figures import APART, FADE_STEPS, FAINTEST
from irsim_gym.rendering.raster.play import LABEL_GAP
from irsim_gym.rendering.raster.ways import DASHES
from irsim_gym.rendering.scene import frame_layout, primitives
from irsim_gym.rendering.scene.primitives import Beams, Cover, Figure, Ink, Pen, Picture, Primitive, Shape, Way, Words
from irsim_gym.rendering.scene.scene import DrawnBody, FogView, Form, GoalView
from irsim_gym.simulator.readings.marks import LineMark, Mark, PointsMark, TextMark

HALF_A_WALL = 1.1
"""Half the width of a wall's line [point], so that a wall along the world's border is drawn in full width."""
LABEL_HEIGHT, LETTER_WIDTH = 1.3, 0.7
"""Height of a label and width of a letter, relative to the type size."""
THINNEST_BAND = 0.3
"""Minimum width of a line with a width in metres [point]."""


class Rank(NamedTuple):
    """The properties of a rank.

    Attributes:
        reach: Extent beyond the world's border before clipping [point]; None for no clipping.
        switch: Name of the page's switch that shows it; empty for none.
    """

    reach: float | None = None
    switch: str = ""


RANKS = {
    "map": Rank(),
    "shadows": Rank(HALF_A_WALL),
    "fixed": Rank(HALF_A_WALL),
    "touch": Rank(),
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
"""All ranks by name; within a layer, later ranks cover earlier ones."""

POLE = Shape(offsets=(np.array(theme.FLAG_POLE),))
PENNANT = Shape(offsets=(np.array([*theme.FLAG_PENNANT, theme.FLAG_PENNANT[0]]),))
WAYPOINT = Shape(dot=2.25)


def page_constants() -> dict[str, Any]:
    """Return the constants for the script of a page."""
    lines = zip(("dashed", "dashdot", "dotted"), DASHES[1:].tolist(), strict=True)
    return {
        "card": theme.CARD,
        "grid": theme.GRID,
        "rule": theme.RULE,
        "margins": {
            side: getattr(frame_layout, side.upper()) for side in ("left", "right", "top", "bottom", "bare", "padding")
        },
        "flag": theme.FLAG,
        "ranks": {name: rank._asdict() for name, rank in RANKS.items()},
        "dashes": {"solid": [], **dict(lines)},
        "label": {"gap": LABEL_GAP, "height": LABEL_HEIGHT, "letter": LETTER_WIDTH},
        "fade": {"steps": FADE_STEPS, "faintest": FAINTEST, "apart": APART},
        "thinnest": THINNEST_BAND,
        "defaults": {kind.__name__: kind._field_defaults for kind in (Pen, Figure, Picture, Way, Beams, Words, Cover)},
    }


def body(view: DrawnBody, span: tuple[float, float] | None, *, fixed: bool) -> Iterator[Primitive]:
    """Yield the primitives of a body in its own frame, except those of collisions.

    Args:
        view: The body.
        span: Width [rad] and depth [m] of its field of view; None if that is not shown.
        fixed: Whether it never moves.
    """
    style, form = view.style, view.form
    rank = "fixed" if fixed else "bodies"
    if view.image is not None and form.corners is not None:
        box = *form.corners[0].tolist(), *form.corners[2].tolist()
        yield Picture(rank, style.order, view.image.pixels, box, view.image.alpha)
    else:
        if fixed and is_filled(form, style):
            yield from (Figure("shadows", style.order, pen, outline(form), shift=shift) for shift, pen in shadows())
        yield from (Figure(rank, style.order, pen, outline(form)) for pen in footprint(form, style))
    if len(form.mark):
        layer = style.order if style.arrow_order is None else style.arrow_order
        pen, mark = Pen(Ink(style.arrow_colour, style.arrow_alpha)), np.vstack([form.mark, form.mark[:1]])
        yield Figure("headings", layer, pen, Shape((mark,)), turned=True)
    if span is not None:
        fill, edge = (Ink(colour, style.field_alpha) for colour in (style.field_colour, style.field_edge_colour))
        yield Figure("fields", style.field_order, Pen(fill, edge, 0.9), Shape(sector=span))
    if style.show_trajectory and not fixed:
        yield way(style)
    if style.ghost is not None and form.ghost is not None and not fixed:
        past, left = (style.ghost_every, style.ghost_length), outline(form.ghost)
        for pen in footprint(form.ghost, style.ghost):
            yield Figure("ghosts", style.ghost.order, pen, left, past=past)
    if style.label or not fixed:
        yield label(style, "labels", style.label) if style.label else label(style, "names", view.name)


def way(style: BodyStyle) -> Way:
    """Return the primitive of a body's path."""
    ink, width = Ink(style.trajectory_colour, style.trajectory_alpha), style.trajectory_width
    pen = Pen(None, ink, width or theme.PATH_WIDTH, style.trajectory_style, width is not None, "butt")
    return Way("paths", style.trajectory_order, pen, style.trajectory_length)


def outline(form: Form) -> Shape:
    """Return a footprint's outline in the body frame."""
    return Shape(form.lines, discs=form.discs)


def is_filled(form: Form, style: BodyStyle) -> bool:
    """Return whether a footprint is drawn as an area rather than a curve."""
    return style.filled and (bool(len(form.discs)) or (bool(form.lines) and form.solid))


def footprint(form: Form, style: BodyStyle) -> tuple[Pen, ...]:
    """Return the pens for a footprint, in order.

    Two pens are used for a footprint of several opaque parts, so that edges inside overlaps are hidden.
    """
    filled = is_filled(form, style)
    fill, edge = Ink(style.colour, style.alpha), Ink(style.colour, style.alpha, 0.68 if filled else 1.0)
    if style.edge_colour is not None:
        edge = Ink(style.edge_colour, style.alpha)
    if not filled:
        return (Pen(None, edge, style.wall_width, style.line_style),)
    if style.alpha == 1.0 and len(form.lines) + len(form.discs) > 1:
        return Pen(None, edge, 2.0 * style.line_width, style.line_style), Pen(fill)
    return (Pen(fill, edge, style.line_width, style.line_style),)


def shadows() -> Iterator[tuple[float, Pen]]:
    """Yield the shift to the right and downwards [point] and the pen of each shadow of a fixed body."""
    for shift, opacity in theme.SHADOWS:
        yield shift, Pen(Ink(theme.SHADOW, opacity), Ink(theme.SHADOW, 0.4 * opacity), 1.5)


def impact(form: Form) -> Iterator[Figure]:
    """Yield the edges of a colliding body, in its own frame."""
    for width, opacity in ((5.0, 0.25), (1.8, 1.0)):
        yield Figure("impacts", TOP, Pen(edge=Ink(theme.IMPACT, opacity), width=width), outline(form))


def goal(view: GoalView) -> Iterator[Primitive]:
    """Yield a goal: the circle of its tolerance, an arrow if the heading counts, later goals, a flag and a label."""
    style, layer, foot = view.style, view.style.goal_order, np.array([[view.x, view.y]])
    faint, strong, full = (Ink(style.goal_colour, share * style.goal_alpha) for share in (0.45, 0.9, 1.0))
    fill = Ink(style.goal_colour, (theme.REACHED_FILL if view.arrived else theme.GOAL_FILL) * style.goal_alpha)
    rim, circle = Pen(fill, strong, 1.1, filled_radius=theme.FILLED_RADIUS), np.array([[0.0, 0.0, view.tolerance]])
    yield Figure("goals", layer, rim, Shape(discs=circle), foot)
    if not math.isnan(view.heading):
        place = np.array([[view.x, view.y, view.heading]])
        yield Figure("goals", layer, Pen(strong), goal_arrow(view.tolerance), place)
    if len(view.later):
        yield Figure("waypoints", layer, Pen(faint), WAYPOINT, view.later)
    yield Figure("flags", layer, Pen(None, full, 1.3, cap="butt"), POLE, foot)
    yield Figure("flags", layer, Pen(full), PENNANT, foot)
    if style.goal_label:
        below = foot - np.array([0.0, view.tolerance])  # the flag is above
        words = label(style, "labels", style.goal_label)
        yield words._replace(places=below, offset=None, drop=LABEL_HEIGHT * style.label_size)


def label(style: BodyStyle, rank: str, text: str) -> Words:
    """Return a text beside a body; only labels, not names, use the label's offset."""
    offset = style.label_offset if rank == "labels" else None
    ink = Ink(style.label_colour, style.label_alpha)
    return Words(rank, style.label_order, text, style.label_size, ink, offset=offset)


def goal_arrow(radius: float) -> Shape:
    """Return the arrow at a goal, whose shaft ends at the circle of this radius [m]; see ``theme.GOAL_ARROW``."""
    least, head, wide, thin = theme.GOAL_ARROW
    reach = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]) * max(radius, 1e-3)
    sides = [(0.0, thin), (0.0, thin), (0.0, wide), (head, 0.0), (0.0, -wide), (0.0, -thin), (0.0, -thin), (0.0, thin)]
    return Shape((np.column_stack([reach, np.zeros(8)]),), (np.array(sides),), least)


def scan(style: ScanStyle, beams: int) -> Iterator[Beams]:
    """Yield the primitives of a scan with ``beams`` beams."""
    speed, tone, alpha = style.velocity, style.colour, style.alpha
    if speed is not None and speed.coloured:
        free = Pen(edge=Ink(speed.free_colour, speed.free_alpha), width=speed.free_width, cap="butt")
        yield Beams("scans", GROUND, "rays", "free", free)
        pen, inks = Pen(edge=Ink(tone, alpha), width=speed.width, cap="butt"), speed_inks(style, alpha)
        yield Beams("scans", GROUND, "rays", "valid", pen, speeds=inks)
    else:
        area, rays = (Ink(tone, min(share * alpha, 1.0)) for share in (0.22, 0.9))
        yield Beams("scans", GROUND, "area", "all", Pen(area))
        pen = Pen(edge=rays, width=0.45, cap="butt")
        yield Beams("scans", GROUND, "rays", "all", pen, -(-beams // MOST_BEAMS))
    if speed is None:
        yield Beams("hits", TOP, "dots", "hits", Pen(Ink(tone, min(3.0 * alpha, 1.0))), radius=1.3)
    elif speed.mark_size > 0.0:
        rim = Pen(Ink(tone), Ink(speed.mark_edge_colour), speed.mark_edge_width)
        radius = 0.5 * math.sqrt(speed.mark_size)
        yield Beams("hits", TOP, "dots", "valid", rim, radius=radius, speeds=speed_inks(style, 1.0))


def speed_inks(style: ScanStyle, opacity: float) -> primitives.SpeedInks | None:
    """Return the colours of radial velocities; None if the sensor does not measure them."""
    speed = style.velocity
    if speed is None:
        return None
    rest, away, nearer = (Ink(name, opacity) for name in (speed.rest_colour, speed.away_colour, speed.nearer_colour))
    return primitives.SpeedInks(rest, away, nearer, speed.full_speed)


def fog(view: FogView) -> Cover:
    """Return the primitive of the fog."""
    return Cover("fog", GROUND, Ink(view.colour, view.alpha))


def outcome(colour: str, bounds: Floats) -> Iterator[Figure]:
    """Yield the marks of an outcome: a tint over the world's rectangle, and a border around it."""
    x_min, y_min, x_max, y_max = bounds.tolist()
    shape = Shape((np.array([(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max), (x_min, y_min)]),))
    yield Figure("touch", GROUND, Pen(Ink(colour, 0.07)), shape)
    yield Figure("frame", math.inf, Pen(edge=Ink(colour, 0.9), width=2.2), shape)


def mark(drawn: Mark) -> Primitive:
    """Return the primitive of a mark over the world."""
    ink = Ink(*faded(drawn.color, drawn.alpha))
    match drawn:
        case LineMark():
            fill = Ink(*faded(drawn.fill, drawn.alpha)) if drawn.fill else None
            points = np.concatenate([drawn.points, drawn.points[:1]]) if drawn.closed else drawn.points
            return Figure("marks", drawn.layer, Pen(fill, ink, drawn.width, drawn.style, cap="butt"), Shape((points,)))
        case PointsMark():
            pen = Pen(edge=ink, width=drawn.width, cap="butt") if drawn.width and drawn.form else Pen(ink)
            form = tuple(drawn.size * part for part in drawn.form)
            shape = Shape(offsets=form) if form else Shape(dot=0.5 * drawn.size)
            return Figure("marks", drawn.layer, pen, shape, drawn.points)
        case TextMark():
            place = np.array([[drawn.x, drawn.y]])
            words = Words("words", drawn.layer, drawn.text, drawn.size, ink, place)
            return words._replace(align=drawn.align, level="middle")
