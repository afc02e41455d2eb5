"""Converts a scene to artists of matplotlib, by way of the primitives of ``vocabulary``."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import Stroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox, BboxBase, IdentityTransform, TransformedBbox

from irsim_gym.base.arraytypes import Floats
from irsim_gym.rendering.figures.figure_images import body_image, fog_image, map_image
from irsim_gym.rendering.looks import fonts, theme
from irsim_gym.rendering.looks.colours import colour
from irsim_gym.rendering.raster.figures import APART, FADE_STEPS, FAINTEST
from irsim_gym.rendering.scene import primitives, vocabulary
from irsim_gym.rendering.scene.frame_layout import DOTS_PER_INCH, POINTS_PER_INCH, Layout
from irsim_gym.rendering.scene.scene import DrawnBody, GoalView, LabelView, ScanView, Scene, TrailView
from irsim_gym.rendering.scene.shapes import placed

TEXT: dict[str, Any] = {"family": theme.FONT, "parse_math": False, "usetex": False}
HALO = 3.0
"""Width of the line around letters with a halo [point]; half of it is visible."""
FULL_TURN = 2.0 * np.pi - 0.01
ARC_STEP = 0.05
"""Angle between two vertices of an arc [rad]."""
RANKS = {name: number for number, name in enumerate(vocabulary.RANKS)}
Drawn = Iterator[tuple[float, str, Artist]]
"""Layers, ranks and artists."""


class SceneArtists:
    """Makes the artists of scenes on one figure.

    Args:
        axes: The axes to draw on.
        layout: Layout of the figure.
        clipped: Whether to clip artists at the world's rectangle.
    """

    def __init__(self, axes: Axes, layout: Layout, *, clipped: bool) -> None:
        self._axes, self._layout, self._clipped = axes, layout, clipped
        self._metre = DOTS_PER_INCH / POINTS_PER_INCH * layout.enlargement / layout.scale

    def add(self, scene: Scene) -> None:
        """Add the artists of a scene to the axes in drawing order."""
        drawn = sorted(self._artists(scene), key=lambda item: (item[0], RANKS[item[1]]))
        for number, (_, rank, artist) in enumerate(drawn):
            artist.set_zorder(10.0 + number)
            self._axes.add_artist(artist)
            artist.set_clip_path(None)
            artist.set_clip_box(None if isinstance(artist, Text) else self._box(rank))

    def _box(self, rank: str) -> BboxBase:
        """Return the clip box of a rank."""
        reach = vocabulary.RANKS[rank].reach
        if reach is None or not self._clipped:
            return self._axes.bbox
        x_min, y_min, x_max, y_max = self._layout.bounds
        left, low, right, high = self._layout.limits
        room = reach * self._metre
        corners = max(x_min - room, left), max(y_min - room, low), min(x_max + room, right), min(y_max + room, high)
        return TransformedBbox(Bbox.from_extents(*corners), self._axes.transData)

    def _artists(self, scene: Scene) -> Drawn:
        """Yield all artists of a scene."""
        fields = {id(view.style): (view.span, view.radius) for view in scene.fields}
        for fixed, views in ((True, scene.fixed), (False, scene.moving)):
            for view in views:
                for primitive in vocabulary.body(view, fields.get(id(view.style)), fixed=fixed):
                    yield from self._of_body(primitive, view)
        for view in scene.ghosts:
            for pen in vocabulary.footprint(view.form, view.style):
                yield view.style.order, "ghosts", self._patch(_outline(view), pen)
        for view in scene.struck:
            for primitive in vocabulary.impact(view.form):
                yield from self._of_body(primitive, view)
        if scene.map is not None:
            yield -math.inf, "map", map_image(self._axes, scene.map)
        for trail in scene.trails:
            yield from self._trail(trail)
        for scan in scene.scans:
            for beams in vocabulary.scan(scan.style, len(scan.ends)):
                yield from self._beams(beams, scan)
        for label in scene.labels:
            yield from self._label(clear_of_flags(label, scene.goals, self._metre))
        for primitive in _free(scene):
            yield from self._placed(primitive, scene)

    def _of_body(self, primitive: primitives.Primitive, view: DrawnBody) -> Drawn:
        """Yield the artists of a primitive in a body's frame; trails and labels have views of their own."""
        match primitive:
            case primitives.Picture() if view.image is not None:
                yield primitive.layer, primitive.rank, body_image(self._axes, view.image)
            case primitives.Figure(past=None):
                x, y, heading = view.pose
                pose = np.array([[x, y, heading + (view.turn if primitive.turned else 0.0)]])
                yield from self._figure(primitive._replace(places=pose))

    def _placed(self, primitive: primitives.Primitive, scene: Scene) -> Drawn:
        """Yield the artists of a primitive in the world frame."""
        match primitive:
            case primitives.Figure():
                yield from self._figure(primitive)
            case primitives.Words() if primitive.places is not None:
                x, y = primitive.places[0].tolist()
                ink, level = primitive.ink, "center" if primitive.level == "middle" else primitive.level
                look = {"ha": primitive.align, "va": level, "size": primitive.size}
                yield from self._text(primitive, x, y, primitive.text, color=ink.colour, alpha=ink.opacity, **look)
            case primitives.Cover() if scene.fog is not None:
                yield primitive.layer, primitive.rank, fog_image(self._axes, scene.fog)

    def _figure(self, figure: primitives.Figure) -> Drawn:
        """Yield the artists of a shape at its places."""
        shape, shift = figure.shape, figure.shift * self._metre
        places = np.zeros((1, 2)) if figure.places is None else figure.places
        if shape.dot:
            yield figure.layer, figure.rank, self._dots(places[:, :2], shape.dot, figure.pen)
            return
        for place in places:
            pose = np.array([place[0] + shift, place[1] - shift, place[2] if len(place) > 2 else 0.0])
            radius = float(shape.discs[0, 2]) / self._metre if shape.discs is not None and len(shape.discs) else 0.0
            yield figure.layer, figure.rank, self._patch(self._path(shape, pose), faded(figure.pen, radius))

    def _path(self, shape: primitives.Shape, pose: Floats) -> Path:
        """Return a shape at a pose [m, m, rad] as a path."""
        parts = []
        for number in range(max(len(shape.chains), len(shape.offsets))):
            points = shape.chains[number] if shape.chains else np.zeros_like(shape.offsets[number])
            if shape.least:
                reach = np.hypot(*points.T)[:, None]
                points = points * np.maximum(shape.least * self._metre / np.maximum(reach, 1e-12), 1.0)
            if shape.offsets:
                points = points + self._metre * shape.offsets[number]
            parts.append(Path(placed(points, pose), closed=_is_closed(points)))
        for x, y, radius in () if shape.discs is None else shape.discs.tolist():
            parts.append(_circle(placed(np.array([[x, y]]), pose)[0], radius))
        if shape.sector is not None:
            parts.append(_sector(*shape.sector, pose))
        return Path.make_compound_path(*parts)

    def _patch(self, path: Path, pen: primitives.Pen) -> PathPatch:
        """Return a path drawn with a pen."""
        width = max(pen.width / self._metre, vocabulary.THINNEST_BAND) if pen.in_metres else pen.width
        has_edge = pen.edge is not None and width > 0.0
        patch = PathPatch(
            path,
            facecolor="none" if pen.fill is None else rgba(pen.fill),
            edgecolor="none" if pen.edge is None or not has_edge else rgba(pen.edge),
            fill=pen.fill is not None,
            linewidth=width if has_edge else 0.0,
            linestyle=pen.line if has_edge else "solid",
            capstyle=pen.cap,
            joinstyle="round",
        )
        patch.set_transform(self._axes.transData)
        return patch

    def _dots(self, places: Floats, radius: float, pen: primitives.Pen, colours: object = None) -> PathCollection:
        """Return discs of a radius [point] at some places [m], with the pen's colour or one colour each."""
        circle, data = Path.unit_circle(), self._axes.transData
        dots = PathCollection([circle], [radius**2], offsets=places, offset_transform=data)
        fill = "none" if pen.fill is None else [rgba(pen.fill)]
        edge = "none" if pen.edge is None else rgba(pen.edge)
        dots.set(facecolor=fill if colours is None else colours, edgecolor=edge, linewidth=pen.width)
        dots.set_transform(IdentityTransform())
        return dots

    def _beams(self, beams: primitives.Beams, view: ScanView) -> Drawn:
        """Yield the artists of one form of a scan."""
        chosen = {"all": np.ones_like(view.hits), "hits": view.hits, "valid": view.valid, "free": ~view.valid}
        which, layer, rank = chosen[beams.which], beams.layer, beams.rank
        ends = view.ends[which][:: beams.every]
        if beams.form == "area":
            corners = ends if view.surrounds else np.vstack([view.origin, ends])
            yield layer, rank, self._patch(Path(np.vstack([corners, corners[:1]]), closed=True), beams.pen)
            return
        if not len(ends):
            return
        colours = None if beams.speeds is None else speed_colours(beams.speeds, view.speeds[which])
        lines = np.stack([np.broadcast_to(view.origin, ends.shape), ends], axis=1)
        if beams.form == "dots":
            yield layer, rank, self._dots(ends, beams.radius, beams.pen, colours)
        elif colours is not None:
            yield layer, rank, LineCollection(list(lines), colors=colours, linewidths=beams.pen.width)
        else:  # one path, so that overlapping rays are not darker
            codes = np.tile([Path.MOVETO, Path.LINETO], len(ends))
            yield layer, rank, self._patch(Path(lines.reshape(-1, 2), codes), beams.pen)

    def _trail(self, view: TrailView) -> Drawn:
        """Yield a body's path: a line that fades towards its start, or a band of a width in metres."""
        way = vocabulary.way(view.style)
        points = thinned(view.points, APART * self._layout.enlargement / self._layout.scale)
        if len(points) < 2 or way.pen.edge is None:
            return
        if way.pen.in_metres:
            yield way.layer, way.rank, self._patch(Path(points), way.pen)
            return
        cuts = np.unique(np.arange(FADE_STEPS + 1) * (len(points) - 1) // FADE_STEPS).tolist()
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))]) / self._metre
        red, green, blue, opacity = rgba(way.pen.edge)
        for k, (first, last) in enumerate(pairwise(cuts)):
            # There is one part less than cuts, and the last part has full opacity.
            share = FAINTEST + (1.0 - FAINTEST) * k / max(len(cuts) - 2, 1)
            line = Line2D(*points[first : last + 1].T, color=(red, green, blue, share * opacity), lw=way.pen.width)
            line.set(dash_capstyle="butt", solid_capstyle="butt", solid_joinstyle="round", dash_joinstyle="round")
            if way.pen.line != "solid":  # dashes continue across parts
                pattern: Any = f"lines.{way.pen.line}_pattern"
                line.set_linestyle((along[first] / way.pen.width, rcParams[pattern]))
            yield way.layer, way.rank, line

    def _label(self, view: LabelView) -> Drawn:
        style, words = view.style, vocabulary.label(view.style, "labels", view.text)
        look = {"ha": "center", "va": "bottom", "size": words.size, "color": words.ink.colour}
        if style.label_halo:  # a separate text, so that files keep the letters as text
            around = [Stroke(linewidth=HALO, foreground=style.label_halo)]
            yield from self._text(words, view.x, view.y, words.text, path_effects=around, **look)
        yield from self._text(words, view.x, view.y, words.text, alpha=words.ink.opacity, **look)

    def _text(self, words: primitives.Words, x: float, y: float, text: str, **look: object) -> Drawn:
        """Yield a text if its place is visible."""
        if self._layout.contains(x, y):
            letters, face = fonts.families(text)
            yield words.layer, words.rank, Text(x, y, letters, **{**TEXT, **face, **look})


def _free(scene: Scene) -> Iterator[primitives.Primitive]:
    """Yield the primitives in the world frame: goals, fog, marks, and the outcome."""
    for view in scene.goals:
        yield from (part for part in vocabulary.goal(view) if not isinstance(part, primitives.Words))
    if scene.fog is not None:
        yield vocabulary.fog(scene.fog)
    for mark in scene.overlay.marks:
        yield vocabulary.mark(mark)
    if theme.ends_episode(scene.status):
        yield from vocabulary.outcome(theme.status_colour(scene.status), scene.bounds)


def rgba(ink: primitives.Ink) -> tuple[float, float, float, float]:
    """Return a colour in matplotlib's form."""
    red, green, blue, opacity = colour(ink.colour, min(ink.opacity, 1.0))
    share = ink.brightness / 255.0
    return red * share, green * share, blue * share, opacity


def faded(pen: primitives.Pen, radius: float) -> primitives.Pen:
    """Return a pen for a disc of a radius [point]; the fill of a large disc gets fainter with its area."""
    if pen.fill is None or not radius > pen.filled_radius > 0.0:
        return pen
    return pen._replace(fill=pen.fill._replace(opacity=pen.fill.opacity * (pen.filled_radius / radius) ** 2))


def speed_colours(inks: primitives.SpeedInks, speeds: Floats) -> Floats:
    """Return the colours of radial velocities ``(n,)``: red, green, blue, opacity, shape ``(n, 4)``."""
    share = np.minimum(np.abs(speeds) / inks.full_speed, 1.0)[:, None]
    ends = np.where(speeds[:, None] >= 0.0, rgba(inks.away), rgba(inks.nearer))
    return np.asarray((1.0 - share) * np.array(rgba(inks.rest)) + share * ends)


def clear_of_flags(view: LabelView, goals: Sequence[GoalView], point: float) -> LabelView:
    """Return a label, moved below its body if it would cover the flag of a goal.

    Args:
        view: The label.
        goals: The visible goals.
        point: Length of a typographic point in the world [m].
    """
    size = view.style.label_size * point
    height, half = vocabulary.LABEL_HEIGHT * size, 0.5 * vocabulary.LETTER_WIDTH * size * len(view.text)
    wide, high = (side * point for side in theme.FLAG)
    meets = any(
        view.x - half - wide <= goal.x <= view.x + half and view.y - high <= goal.y <= view.y + height for goal in goals
    )
    if view.under is None or not meets:
        return view
    return LabelView(view.x, view.under - height, view.text, view.style, view.under)


def thinned(points: Floats, apart: float) -> Floats:
    """Return points ``(n, 2)`` thinned to distances of about ``apart`` [m] along the path."""
    if len(points) < 3:
        return points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    is_drawn = np.concatenate([[True], np.diff(np.floor(along / apart)) > 0])
    is_drawn[-1] = True
    return np.asarray(points[is_drawn], np.float64)


def _outline(view: DrawnBody) -> Path:
    """Return a body's footprint as one path: its chains, then its discs."""
    parts = [Path(line, closed=_is_closed(line)) for line in view.lines]
    return Path.make_compound_path(*parts, *(_circle(row[:2], row[2]) for row in view.discs))


def _is_closed(vertices: Floats) -> bool:
    return len(vertices) > 2 and bool(np.abs(vertices[0] - vertices[-1]).max() < 1e-6)


def _circle(middle: Floats, radius: float) -> Path:
    circle = Path.unit_circle()
    return Path(np.asarray(circle.vertices) * radius + middle, circle.codes)


def _sector(span: float, radius: float, pose: Floats) -> Path:
    """Return a sector centred on the heading, or a disc if it spans a full turn."""
    if span >= FULL_TURN:
        return _circle(pose[:2], radius)
    angles = np.linspace(-0.5, 0.5, max(math.ceil(span / ARC_STEP), 2) + 1) * span
    arc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Path(placed(np.vstack([np.zeros((1, 2)), arc, np.zeros((1, 2))]), pose), closed=True)
