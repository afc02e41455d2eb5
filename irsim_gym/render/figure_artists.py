"""A scene as ordinary artists of matplotlib: one or a few for each thing that it shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import Stroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox, BboxBase, IdentityTransform, ScaledTranslation, TransformedBbox

from irsim_gym.arraytypes import Floats
from irsim_gym.raster.figures import APART, FADE_STEPS, FAINTEST
from irsim_gym.render import fonts, shapes, theme
from irsim_gym.render.colours import Colour, colour, shade
from irsim_gym.render.figure_images import body_image, fog_image, map_image
from irsim_gym.render.layout import DOTS_PER_INCH, POINTS_PER_INCH, Layout
from irsim_gym.render.scene import BodyView, FieldView, GoalView, LabelView, ScanView, Scene, TrailView
from irsim_gym.render.styles import GROUND, TOP, VelocityStyle, faded
from irsim_gym.world.marks import LineMark, PointsMark, TextMark

(
    FIXED, TINT, FOG, GHOSTS, SCANS, FIELDS, GOALS, FLAGS, PATHS, MOVING, HEADINGS, HITS, IMPACTS, LABELS, MARKS, WORDS,
) = range(16)  # fmt: skip
"""What covers what within a layer."""
TEXT: dict[str, Any] = {"family": theme.FONT, "parse_math": False, "usetex": False}
HALO = 3.0
"""Width of the line around letters with a halo [point]; half of it is seen."""
Key = tuple[float, int]
Drawn = Iterator[tuple[Key, Artist, BboxBase | None]]


class SceneArtists:
    """Makes the artists of scenes on one figure.

    Args:
        axes: Where they are drawn.
        layout: Where the world is on it.
        clipped: Cut what reaches beyond the world's rectangle.
    """

    def __init__(self, axes: Axes, layout: Layout, *, clipped: bool) -> None:
        self._axes, self._layout = axes, layout
        self._metre = DOTS_PER_INCH / POINTS_PER_INCH * layout.enlargement / layout.scale
        self._plot: BboxBase = axes.bbox
        self._inner, self._walls = (self._within(margin) if clipped else self._plot for margin in (0.0, 1.1))

    def _within(self, margin: float) -> BboxBase:
        """Return the part of the world that is shown, wider by a margin [point]."""
        x_min, y_min, x_max, y_max = self._layout.bounds
        left, low, right, high = self._layout.limits
        room = margin * self._metre
        corners = max(x_min - room, left), max(y_min - room, low), min(x_max + room, right), min(y_max + room, high)
        return TransformedBbox(Bbox.from_extents(*corners), self._axes.transData)

    def add(self, scene: Scene) -> None:
        """Add the artists of a scene to the axes, in the order in which they cover each other."""
        found = [*self._live(scene), *self._marks(scene)]
        floor = min((key[0] for key, *_ in found), default=TOP)
        found += [item for view in scene.fixed for item in self._body(view, FIXED, shadows=True)]
        if theme.ends_episode(scene.status):
            tone = theme.status_colour(scene.status)
            found += self._area((floor, TINT), _rectangle(scene.bounds), colour(tone, 0.07), box=self._plot)
            frame = _rectangle(scene.bounds)
            found += self._area((np.inf, WORDS), frame, None, colour(tone, 0.9), 2.2, box=self._plot)
        if scene.map is not None:
            found.append(((-np.inf, FIXED), map_image(self._axes, scene.map), self._plot))
        for number, (_, artist, box) in enumerate(sorted(found, key=lambda item: item[0])):
            artist.set_zorder(10.0 + number)
            self._axes.add_artist(artist)
            artist.set_clip_path(None)
            artist.set_clip_box(box)

    def _live(self, scene: Scene) -> Drawn:
        """Yield all that may change from moment to moment."""
        if scene.fog is not None:
            yield (GROUND, FOG), fog_image(self._axes, scene.fog), self._inner
        for view in scene.ghosts:
            yield from self._body(view, GHOSTS)
        for scan in scene.scans:
            yield from self._scan(scan)
            yield from self._hits(scan)
        for field in scene.fields:
            yield from self._field(field)
        for goal in scene.goals:
            yield from self._goal(goal)
        for trail in scene.trails:
            yield from self._trail(trail)
        for view in scene.moving:
            yield from self._body(view, MOVING)
        for view in scene.fixed + scene.moving:
            yield from self._heading(view)
        for view in scene.struck:
            for width, opacity in ((5.0, 0.25), (1.8, 1.0)):
                path = outline(view)
                yield from self._path((TOP, IMPACTS), path, None, colour(theme.IMPACT, opacity), width, box=self._walls)
        for label in clear_of_flags(scene.labels, scene.goals, self._metre):
            if self._layout.contains(label.x, label.y):
                yield from self._label(label)

    def _path(
        self,
        key: Key,
        path: Path,
        fill: Colour | None,
        edge: Colour | None = None,
        width: float = 0.0,
        *,
        style: Any = "solid",
        cap: str = "round",
        box: BboxBase | None = None,
        transform: Any = None,
    ) -> Drawn:
        """Yield a path with its area and its line; widths are points."""
        patch = PathPatch(
            path,
            facecolor="none" if fill is None else _rgba(fill),
            edgecolor="none" if edge is None or width <= 0.0 else _rgba(edge),
            fill=fill is not None,
            linewidth=width,
            linestyle=style if width > 0.0 else "solid",
            capstyle=cap,
            joinstyle="round",
        )
        patch.set_transform(self._axes.transData if transform is None else transform)
        yield key, patch, box or self._inner

    def _area(
        self,
        key: Key,
        corners: Floats,
        fill: Colour | None,
        edge: Colour | None = None,
        width: float = 0.0,
        **rest: Any,
    ) -> Drawn:
        """Yield a polygon; its last corner need not repeat the first."""
        yield from self._path(key, Path(np.vstack([corners, corners[:1]]), closed=True), fill, edge, width, **rest)

    def _body(self, view: BodyView, rank: int, *, shadows: bool = False) -> Drawn:
        """Yield a footprint or an image; one of several opaque parts has no edges where they overlap."""
        style, key = view.style, (view.style.order, rank)
        box = self._inner if rank == GHOSTS else self._walls
        if view.image is not None:
            yield key, body_image(self._axes, view.image), box
            return
        path, is_filled = outline(view), shapes.is_filled(view)
        for shift, alpha in theme.SHADOWS if shadows and is_filled else ():
            offset = ScaledTranslation(shift / POINTS_PER_INCH, -shift / POINTS_PER_INCH, self._dots())
            fill, edge = colour(theme.SHADOW, alpha), colour(theme.SHADOW, 0.4 * alpha)
            yield from self._path(key, path, fill, edge, 1.5, box=box, transform=self._axes.transData + offset)
        if style.edge_colour is not None:
            edge = colour(style.edge_colour, style.alpha)
        else:
            edge = shade(style.colour, 0.68, style.alpha) if is_filled else colour(style.colour, style.alpha)
        look: dict[str, Any] = {"style": style.line_style, "box": box}
        if not is_filled:
            yield from self._path(key, path, None, edge, style.wall_width, **look)
            return
        fill, in_parts = colour(style.colour, style.alpha), len(view.lines) + len(view.discs) > 1
        if in_parts and style.alpha == 1.0:
            yield from self._path(key, path, None, edge, 2.0 * style.line_width, **look)
            yield from self._path(key, path, fill, box=box)
        else:
            yield from self._path(key, path, fill, edge, style.line_width, **look)

    def _dots(self) -> Any:
        figure: Any = self._axes.figure
        return figure.dpi_scale_trans

    def _heading(self, view: BodyView) -> Drawn:
        style = view.style
        if len(view.heading):
            key = style.order if style.arrow_order is None else style.arrow_order, HEADINGS
            yield from self._area(key, view.heading, colour(style.arrow_colour, style.arrow_alpha), box=self._walls)

    def _scan(self, view: ScanView) -> Drawn:
        """Yield the area seen and the beams, or beams in the colours of their radial velocities."""
        style, key = view.style, (GROUND, SCANS)
        if style.velocity is None or not style.velocity.coloured:
            yield from self._area(key, shapes.seen(view), colour(style.colour, min(0.22 * style.alpha, 1.0)))
            beams = view.ends[:: -(-len(view.ends) // shapes.MOST_BEAMS)]
            yield from self._rays(key, view.origin, beams, colour(style.colour, min(0.9 * style.alpha, 1.0)), 0.45)
            return
        speed = style.velocity
        free = colour(speed.free_colour, speed.free_alpha)
        yield from self._rays(key, view.origin, view.ends[~view.valid], free, speed.free_width)
        lines = np.stack([np.broadcast_to(view.origin, view.ends.shape), view.ends], axis=1)[view.valid]
        colours = velocity_colours(view, speed, style.alpha)
        yield key, LineCollection(list(lines), colors=colours, linewidths=speed.width), self._inner

    def _rays(self, key: Key, origin: Floats, ends: Floats, ink: Colour, width: float) -> Drawn:
        """Yield the lines from a point to others as one path, which is no darker where they overlap."""
        if len(ends):
            points = np.stack([np.broadcast_to(origin, ends.shape), ends], axis=1).reshape(-1, 2)
            path = Path(points, np.tile([Path.MOVETO, Path.LINETO], len(ends)))
            yield from self._path(key, path, None, ink, width, cap="butt")

    def _hits(self, view: ScanView) -> Drawn:
        speed = view.style.velocity
        if speed is None:
            ink = colour(view.style.colour, min(3.0 * view.style.alpha, 1.0))
            yield (TOP, HITS), self._dots_at(view.ends[view.hits], 2.6, [_rgba(ink)]), self._inner
        elif speed.mark_size > 0.0:
            colours = velocity_colours(view, speed, 1.0)
            marks = self._dots_at(view.ends[view.valid], np.sqrt(speed.mark_size), colours)
            marks.set(edgecolor=speed.mark_edge_colour, linewidth=speed.mark_edge_width)
            yield (TOP, HITS), marks, self._inner

    def _dots_at(self, places: Floats, width: float, colours: Any) -> PathCollection:
        """Return discs of a width [point] at some places [m]."""
        dots = PathCollection(
            [Path.unit_circle()], [0.25 * width**2], offsets=places, offset_transform=self._axes.transData
        )
        dots.set(facecolor=colours, edgecolor="none", transform=IdentityTransform())
        return dots

    def _field(self, view: FieldView) -> Drawn:
        style = view.style
        fill, edge = (colour(name, style.field_alpha) for name in (style.field_colour, style.field_edge_colour))
        yield from self._area((style.field_order, FIELDS), shapes.sector(view), fill, edge, 0.9)

    def _goal(self, view: GoalView) -> Drawn:
        """Yield the circle of a goal's tolerance, an arrow where its heading counts, dots and a flag."""
        style, layer, metre = view.style, view.style.goal_order, self._metre
        tones = {share: colour(style.goal_colour, share * style.goal_alpha) for share in (1.0, 0.9, 0.45)}
        filled = theme.goal_fill(view.tolerance / metre, arrived=view.arrived) * style.goal_alpha
        circle = disc(view.x, view.y, view.tolerance)
        yield from self._path(
            (layer, GOALS), circle, colour(style.goal_colour, filled), tones[0.9], 1.1, box=self._plot
        )
        if not np.isnan(view.heading):
            arrow = shapes.goal_arrow(view.x, view.y, view.tolerance, view.heading, metre)
            yield from self._area((layer, GOALS), arrow, tones[0.9], box=self._plot)
        if len(view.later):
            yield (layer, FLAGS), self._dots_at(view.later, 4.5, [_rgba(tones[0.45])]), self._plot
        foot = np.array([view.x, view.y])
        pole, pennant = (foot + metre * np.array(part) for part in (theme.FLAG_POLE, theme.FLAG_PENNANT))
        yield from self._path((layer, FLAGS), Path(pole), None, tones[1.0], 1.3, cap="butt", box=self._plot)
        yield from self._area((layer, FLAGS), pennant, tones[1.0], box=self._plot)

    def _trail(self, view: TrailView) -> Drawn:
        """Yield the way that a body came: a thin one fades towards its beginning, one with a width is a band."""
        style, key = view.style, (view.style.trajectory_order, PATHS)
        points = shapes.thinned(view.points, APART * self._layout.enlargement / self._layout.scale)
        if len(points) < 2:
            return
        ink = colour(style.trajectory_colour, style.trajectory_alpha)
        if style.trajectory_width is not None:
            width = max(style.trajectory_width / self._metre, 0.3)
            yield from self._path(key, Path(points), None, ink, width, style=style.trajectory_style, cap="butt")
            return
        cuts = np.unique(np.arange(FADE_STEPS + 1) * (len(points) - 1) // FADE_STEPS).tolist()
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))]) / self._metre
        for k, (first, last) in enumerate(pairwise(cuts)):
            share = FAINTEST + (1.0 - FAINTEST) * k / max(len(cuts) - 2, 1)
            line = Line2D(*points[first : last + 1].T, color=_rgba((*ink[:3], ink[3] * share)), lw=theme.PATH_WIDTH)
            line.set(dash_capstyle="butt", solid_capstyle="butt", solid_joinstyle="round", dash_joinstyle="round")
            if style.trajectory_style != "solid":  # the dashes go on from one part to the next
                pattern: Any = f"lines.{style.trajectory_style}_pattern"
                line.set_linestyle((along[first] / theme.PATH_WIDTH, rcParams[pattern]))
            yield key, line, self._inner

    def _label(self, view: LabelView) -> Drawn:
        style = view.style
        look = {"size": style.label_size, "color": style.label_colour, "alpha": style.label_alpha}
        words, face = fonts.families(view.text)
        for is_halo in (True, False) if style.label_halo else (False,):
            text = Text(view.x, view.y, words, ha="center", va="bottom", **{**TEXT, **face, **look})
            if is_halo:  # apart from the letters, so that a file holds them as letters
                text.set_path_effects([Stroke(linewidth=HALO, foreground=style.label_halo)])
            yield (style.label_order, LABELS), text, None

    def _marks(self, scene: Scene) -> Drawn:
        """Yield what somebody drew over the world."""
        for mark in scene.overlay.marks:
            match mark:
                case LineMark():
                    points = np.vstack([mark.points, mark.points[:1]]) if mark.closed else mark.points
                    fill = colour(*faded(mark.fill, mark.alpha)) if mark.fill else None
                    edge = colour(*faded(mark.color, mark.alpha))
                    path, key = Path(points, closed=mark.closed), (mark.layer, MARKS)
                    yield from self._path(key, path, fill, edge, mark.width, style=mark.style, cap="butt")
                case PointsMark():
                    yield from self._points(mark)
                case TextMark() if self._layout.contains(mark.x, mark.y):
                    tone, alpha = faded(mark.color, mark.alpha)
                    words, face = fonts.families(mark.text)
                    look = {**TEXT, **face, "size": mark.size, "color": tone, "alpha": alpha}
                    yield (mark.layer, WORDS), Text(mark.x, mark.y, words, ha=mark.align, va="center", **look), None

    def _points(self, mark: PointsMark) -> Drawn:
        ink, size, key = colour(*faded(mark.color, mark.alpha)), mark.size * self._metre, (mark.layer, MARKS)
        if not mark.form:
            yield key, self._dots_at(mark.points, mark.size, [_rgba(ink)]), self._inner
        for place in mark.points:
            for part in mark.form:
                if mark.width > 0.0:
                    yield from self._path(key, Path(place + size * part), None, ink, mark.width, cap="butt")
                else:
                    yield from self._area(key, place + size * part, ink)


def outline(view: BodyView) -> Path:
    """Return a body's footprint as one path: its chains, then its discs."""
    parts = [Path(line, closed=shapes.is_closed(line)) for line in view.lines]
    return Path.make_compound_path(*parts, *(disc(*row) for row in view.discs.tolist()))


def disc(x: float, y: float, radius: float) -> Path:
    """Return a circle."""
    circle = Path.unit_circle()
    return Path(np.asarray(circle.vertices) * radius + np.array([x, y]), circle.codes)


def clear_of_flags(labels: Sequence[LabelView], goals: Sequence[GoalView], point: float) -> list[LabelView]:
    """Return labels, those of bodies below them where they would stand on the flag of a goal.

    Args:
        labels: The labels.
        goals: The goals that are shown.
        point: A point of type [m].
    """
    return [_lowered(view, goals, point) for view in labels]


def _lowered(view: LabelView, goals: Sequence[GoalView], point: float) -> LabelView:
    height, half = 1.3 * view.style.label_size * point, 0.35 * view.style.label_size * len(view.text) * point
    wide, high = (side * point for side in theme.FLAG)
    meets = any(
        goal.x + wide >= view.x - half
        and goal.x <= view.x + half
        and goal.y + high >= view.y
        and goal.y <= view.y + height
        for goal in goals
    )
    if view.under is None or not meets:
        return view
    return LabelView(view.x, view.under - height, view.text, view.style, view.under)


def velocity_colours(view: ScanView, style: VelocityStyle, alpha: float) -> Floats:
    """Return the colours of the beams that hit: the sign's, mixed with that of rest below the full speed.

    Returns:
        Red, green, blue, opacity, shape ``(n_valid, 4)``.
    """
    speeds = view.speeds[view.valid]
    share = np.minimum(np.abs(speeds) / style.full_speed, 1.0)[:, None]
    ends = np.where(speeds[:, None] >= 0.0, to_rgba(style.away_colour), to_rgba(style.nearer_colour))
    colours: Floats = (1.0 - share) * np.array(to_rgba(style.rest_colour)) + share * ends
    colours[:, 3] = alpha
    return colours


def _rectangle(bounds: Floats) -> Floats:
    x_min, y_min, x_max, y_max = bounds.tolist()
    return np.array([(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)])


def _rgba(ink: Colour) -> tuple[float, float, float, float]:
    red, green, blue, alpha = ink
    return red / 255.0, green / 255.0, blue / 255.0, min(alpha, 1.0)
