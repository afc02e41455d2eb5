"""Matplotlib artists of one axes, made once and given new data for every frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import ScaledTranslation

from irsim_gym.arraytypes import Floats
from irsim_gym.render import shapes, theme
from irsim_gym.render.scene import BodyView, GoalView, ScanView, TrailView
from irsim_gym.render.styles import BodyStyle

Colour = tuple[float, float, float, float]

FAINTEST = 0.12
POLE = Path([(0.0, 0.0), (0.0, 2.0)])
PENNANT = Path([(0.0, 2.0), (1.25, 1.55), (0.0, 1.1), (0.0, 2.0)], closed=True)


class Bodies:
    """Footprints, their edges and the marks of their headings.

    Args:
        axes: Where they are drawn.
        shadows: Draw a soft shadow below them; for bodies that are drawn once, since it costs.
    """

    def __init__(self, axes: Axes, *, shadows: bool = False) -> None:
        self._shadows = (
            [_shadow(axes, pixels, alpha) for pixels, alpha in ((2.2, 0.05), (1.2, 0.07))] if shadows else []
        )
        self._footprints = _paths(axes)
        self._headings = _paths(axes)

    def update(self, views: Sequence[BodyView]) -> None:
        """Show these bodies, the first one lowest."""
        paths = [shapes.outline_path(view) for view in views]
        filled = [shapes.is_filled(view) for view in views]
        for shadow in self._shadows:
            shadow.set_paths([path for path, is_filled in zip(paths, filled, strict=True) if is_filled])
        styles = [view.style for view in views]
        fills = [_fill(style) if is_filled else (0.0,) * 4 for style, is_filled in zip(styles, filled, strict=True)]
        edges = [_edge(style, is_filled) for style, is_filled in zip(styles, filled, strict=True)]
        self._footprints.set_paths(paths)
        _paint(self._footprints, fills, edges)
        self._footprints.set_linewidths(
            [
                style.line_width if is_filled else style.wall_width
                for style, is_filled in zip(styles, filled, strict=True)
            ]
        )
        self._footprints.set_linestyles([style.line_style for style in styles] or ["solid"])
        marked = [view for view in views if len(view.heading)]
        self._headings.set_paths([Path(np.vstack([view.heading, view.heading[:1]]), closed=True) for view in marked])
        colours = [to_rgba(view.style.arrow_colour, view.style.arrow_alpha * view.style.alpha) for view in marked]
        _paint(self._headings, colours, [(0.0,) * 4] * len(colours))

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        for shadow in self._shadows:
            shadow.draw(renderer)
        self._footprints.draw(renderer)
        self._headings.draw(renderer)


class Impacts:
    """A red edge around bodies that collide."""

    def __init__(self, axes: Axes) -> None:
        self._edges = _paths(axes)
        self._edges.set_linewidths([5.0, 1.8])

    def update(self, views: Sequence[BodyView]) -> None:
        """Show these bodies as colliding."""
        paths = [shapes.outline_path(view) for view in views]
        self._edges.set_paths([path for path in paths for _ in range(2)])
        colours = [to_rgba(theme.IMPACT, 0.25), to_rgba(theme.IMPACT, 1.0)]
        _paint(self._edges, [(0.0,) * 4], colours)

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        self._edges.draw(renderer)


class Trails:
    """Trajectories that fade towards their beginning."""

    def __init__(self, axes: Axes, pixels_per_metre: float, pixels_per_point: float) -> None:
        self._lines: Any = LineCollection([], capstyle="butt", joinstyle="round", animated=True)
        axes.add_collection(self._lines, autolim=False)
        self._points_per_metre = pixels_per_metre / pixels_per_point
        self._apart = 1.5 / pixels_per_metre

    def update(self, views: Sequence[TrailView]) -> None:
        """Show these trajectories."""
        pieces: list[Floats] = []
        colours: list[Colour] = []
        widths: list[float] = []
        styles: list[str] = []
        for view in views:
            parts = shapes.pieces(shapes.thinned(view.points, self._apart))
            strengths = np.linspace(FAINTEST, 1.0, len(parts)) * view.style.trajectory_alpha
            width = view.style.trajectory_width
            pieces += parts
            colours += [to_rgba(view.style.trajectory_colour, strength) for strength in strengths]
            widths += [1.9 if width is None else max(width * self._points_per_metre, 0.3)] * len(parts)
            styles += [view.style.trajectory_style] * len(parts)
        self._lines.set_segments(pieces)
        self._lines.set_color(colours)
        self._lines.set_linewidths(widths or [1.0])
        self._lines.set_linestyles(styles or ["solid"])

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        self._lines.draw(renderer)


class Goals:
    """For each goal the circle of its tolerance, a flag, and dots for the goals after it."""

    def __init__(self, axes: Axes) -> None:
        self._circles = _paths(axes)
        self._circles.set_linewidths([1.1])
        self._later = Line2D([], [], linestyle="none", marker="o", animated=True)
        self._flags = [
            Line2D([], [], linestyle="none", marker=shape, markersize=20.0, animated=True) for shape in (POLE, PENNANT)
        ]
        self._flags[0].set_markeredgewidth(1.3)
        self._flags[1].set_markeredgewidth(0.0)
        for line in (self._later, *self._flags):
            axes.add_line(line)
        self._views: Sequence[GoalView] = ()
        self._later.set_markersize(4.5)

    def update(self, views: Sequence[GoalView]) -> None:
        """Show these goals."""
        self._views = views
        self._circles.set_paths([shapes.circle_path(view.x, view.y, view.tolerance) for view in views])
        colours = [to_rgba(view.style.goal_colour, view.style.goal_alpha) for view in views]
        _paint(
            self._circles,
            [_faded(colour, 0.30 if view.arrived else 0.14) for colour, view in zip(colours, views, strict=True)],
            [_faded(colour, 0.9) for colour in colours],
        )

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave; flags one after another, because each has its colour."""
        self._circles.draw(renderer)
        for view in self._views:
            colour = to_rgba(view.style.goal_colour, view.style.goal_alpha)
            if len(view.later):
                self._later.set_data(view.later[:, 0], view.later[:, 1])
                self._later.set_color(_faded(colour, 0.45))
                self._later.draw(renderer)
            for line in self._flags:
                line.set_data([view.x], [view.y])
                line.set_color(colour)
                line.draw(renderer)


class Scans:
    """For each scan the area seen and the beams."""

    def __init__(self, axes: Axes) -> None:
        self._area = PathPatch(Path([(0.0, 0.0)]), linewidth=0.0, animated=True)
        self._beams = PathPatch(Path([(0.0, 0.0)]), linewidth=0.45, fill=False, animated=True)
        axes.add_patch(self._area)
        axes.add_patch(self._beams)
        self._views: Sequence[ScanView] = ()

    def update(self, views: Sequence[ScanView]) -> None:
        """Show these scans."""
        self._views = views

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave, one scan after another: collections of few large paths are slow."""
        for view in self._views:
            colour, alpha = view.style.colour, view.style.alpha
            self._area.set(path=shapes.seen_path(view), facecolor=to_rgba(colour, min(0.22 * alpha, 1.0)))
            self._beams.set(path=shapes.beam_path(view), edgecolor=to_rgba(colour, min(0.9 * alpha, 1.0)))
            self._area.draw(renderer)
            self._beams.draw(renderer)


class Hits:
    """The points where beams end on something."""

    def __init__(self, axes: Axes) -> None:
        self._dots = Line2D([], [], linestyle="none", marker="o", markersize=2.6, markeredgewidth=0.0, animated=True)
        axes.add_line(self._dots)
        self._views: Sequence[ScanView] = ()

    def update(self, views: Sequence[ScanView]) -> None:
        """Show the hits of these scans."""
        self._views = views

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        for view in self._views:
            ends = view.ends[view.hits]
            self._dots.set_data(ends[:, 0], ends[:, 1])
            self._dots.set_color(to_rgba(view.style.colour, min(3.0 * view.style.alpha, 1.0)))
            self._dots.draw(renderer)


class Labels:
    """Texts beside bodies and goals."""

    def __init__(self, axes: Axes) -> None:
        self._text = Text(family=theme.FONT, ha="center", va="bottom", parse_math=False, usetex=False, animated=True)
        axes.add_artist(self._text)
        self._items: list[tuple[float, float, str, BodyStyle]] = []

    def update(self, bodies: Iterable[BodyView], goals: Iterable[GoalView]) -> None:
        """Show the labels of these bodies and goals."""
        self._items = [(*view.anchor, view.style.label, view.style) for view in bodies if view.style.label]
        self._items += [
            (view.x, view.y - view.tolerance, view.style.goal_label, view.style)
            for view in goals
            if view.style.goal_label
        ]

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        for x, y, words, style in self._items:
            self._text.set(position=(x, y), text=words, color=style.label_colour, alpha=style.label_alpha)
            self._text.set_fontsize(style.label_size)
            self._text.draw(renderer)


def _fill(style: BodyStyle) -> Colour:
    return to_rgba(style.colour, style.alpha)


def _edge(style: BodyStyle, is_filled: bool) -> Colour:
    """Return the colour of the edge: a line's own, or a darker shade of the fill."""
    if style.edge_colour is not None:
        return to_rgba(style.edge_colour, style.alpha)
    red, green, blue, alpha = to_rgba(style.colour, style.alpha)
    return (0.68 * red, 0.68 * green, 0.68 * blue, alpha) if is_filled else (red, green, blue, alpha)


def _faded(colour: Colour, share: float) -> Colour:
    return *colour[:3], colour[3] * share


def _paths(axes: Axes) -> Any:
    """Add an empty collection of paths in world coordinates, which no full draw of the figure shows."""
    collection: Any = PathCollection([], transform=axes.transData, animated=True)
    collection.set(capstyle="round", joinstyle="round")
    # With two entries a lone path is not drawn as if it were a marker, which is slower.
    collection.set_antialiased([True, True])
    axes.add_collection(collection, autolim=False)
    return collection


def _shadow(axes: Axes, pixels: float, alpha: float) -> Any:
    collection = _paths(axes)
    shift = pixels / 72.0
    collection.set_transform(axes.transData + ScaledTranslation(shift, -shift, axes.figure.dpi_scale_trans))
    _paint(collection, [to_rgba(theme.SHADOW, alpha)], [to_rgba(theme.SHADOW, 0.4 * alpha)])
    collection.set_linewidths([1.5])
    return collection


def _paint(collection: Any, fills: Sequence[Colour], edges: Sequence[Colour]) -> None:
    collection.set_facecolors(fills or [(0.0,) * 4])
    collection.set_edgecolors(edges or [(0.0,) * 4])
