"""The figure: world frame, ticks, title and status line around the area where the artists play."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from irsim_gym.arraytypes import Bytes
from irsim_gym.render import artists, theme
from irsim_gym.render.layout import Layout, tick_positions
from irsim_gym.render.scene import BodyView, Scene

DOTS_PER_INCH = 100.0
POINTS_PER_INCH = 72.0
REMEMBERED_BACKDROPS = 8
TEXT = {"family": theme.FONT, "parse_math": False, "usetex": False}


class Stage:
    """A figure that shows scenes of one world size; everything on it is made once.

    What does not move is drawn into a backdrop for each world, which is drawn again only when it changes.

    Args:
        layout: Where things stand on it.
        title: Heading of the picture.
        axis: Draw ticks and the world's frame.
        show_title: Draw heading and status line.
    """

    def __init__(self, layout: Layout, title: str, *, axis: bool = True, show_title: bool = True) -> None:
        dpi = DOTS_PER_INCH * layout.enlargement
        self._figure = Figure(figsize=(layout.width / dpi, layout.height / dpi), dpi=dpi, facecolor=theme.PAPER)
        self._canvas: Any = FigureCanvasAgg(self._figure)
        axes = _axes(self._figure, layout, axis)
        self._fixed = artists.Bodies(axes, shadows=True)
        self._scans = artists.Scans(axes)
        self._ghosts = artists.Bodies(axes)
        self._goals = artists.Goals(axes)
        self._trails = artists.Trails(axes, layout.scale, dpi / POINTS_PER_INCH)
        self._moving = artists.Bodies(axes)
        self._hits = artists.Hits(axes)
        self._impacts = artists.Impacts(axes)
        self._labels = artists.Labels(axes)
        # The order in which they cover each other.
        self._parts = (
            self._scans,
            self._ghosts,
            self._goals,
            self._trails,
            self._moving,
            self._hits,
            self._impacts,
            self._labels,
        )
        self._outcome = _frame(axes, layout, linewidth=2.2, animated=True)
        self._head = _Head(self._figure, layout, title) if show_title else None
        self._backdrops: dict[int, tuple[tuple[BodyView, ...], Any]] = {}

    def draw(self, scene: Scene) -> Bytes:
        """Return a picture of the scene, shape ``(height, width, 3)``, in memory of its own."""
        self._canvas.restore_region(self._backdrop(scene))
        renderer = self._canvas.get_renderer()
        self._scans.update(scene.scans)
        self._ghosts.update(scene.ghosts)
        self._goals.update(scene.goals)
        self._trails.update(scene.trails)
        self._moving.update(scene.moving)
        self._hits.update(scene.scans)
        self._impacts.update(scene.struck)
        self._labels.update(scene.fixed + scene.moving, scene.goals)
        for part in self._parts:
            part.draw(renderer)
        if theme.ends_episode(scene.status):
            colour = theme.status_colour(scene.status)
            self._outcome.set(facecolor=to_rgba(colour, 0.07), edgecolor=to_rgba(colour, 0.9))
            self._outcome.draw(renderer)
        if self._head is not None:
            self._head.draw(renderer, scene)
        return _without_alpha(np.asarray(self._canvas.buffer_rgba()))

    def count_artists(self) -> int:
        """Return how many artists the figure holds."""
        return len(self._figure.findobj())

    def _backdrop(self, scene: Scene) -> Any:
        """Return the canvas with all that does not move in the scene's world."""
        known = self._backdrops.pop(scene.world, None)
        if known is None or known[0] is not scene.fixed:
            self._canvas.draw()
            self._fixed.update(scene.fixed)
            self._fixed.draw(self._canvas.get_renderer())
            known = scene.fixed, self._canvas.copy_from_bbox(self._figure.bbox)
            if len(self._backdrops) >= REMEMBERED_BACKDROPS:
                self._backdrops.pop(next(iter(self._backdrops)))
        self._backdrops[scene.world] = known
        return known[1]


class _Head:
    """The line above the drawing area: title on the left, status and time on the right."""

    def __init__(self, figure: Figure, layout: Layout, title: str) -> None:
        y = 1.0 - 21.0 * layout.enlargement / layout.height
        left = layout.left / layout.width
        right = (layout.left + layout.plot_width) / layout.width
        common: dict[str, Any] = {**TEXT, "va": "center"}
        figure.text(left, y, title, color=theme.INK, fontsize=9.5, weight="bold", ha="left", **common)
        self._time = figure.text(right, y, "", color=theme.INK, fontsize=9.0, ha="right", animated=True, **common)
        self._status = figure.text(
            right - 66.0 * layout.enlargement / layout.width, y, "", fontsize=9.0, ha="right", animated=True, **common
        )

    def draw(self, renderer: RendererBase, scene: Scene) -> None:
        """Draw the scene's status and time."""
        for text, words, colour in (
            (self._time, f"{scene.time:.1f} s", theme.INK),
            (self._status, f"\N{BLACK CIRCLE} {scene.status.replace('_', ' ')}", theme.status_colour(scene.status)),
        ):
            text.set(text=words, color=colour)
            text.draw(renderer)


def _axes(figure: Figure, layout: Layout, axis: bool) -> Axes:
    """Add the drawing area: a white card with the world's frame, a faint grid and ticks in metres."""
    place = (
        layout.left / layout.width,
        layout.bottom / layout.height,
        layout.plot_width / layout.width,
        layout.plot_height / layout.height,
    )
    axes = figure.add_axes(place)
    x_min, y_min, x_max, y_max = layout.limits
    axes.set(xlim=(x_min, x_max), ylim=(y_min, y_max), xticks=[], yticks=[], facecolor=theme.PAPER)
    axes.set_axis_off()
    _frame(axes, layout, facecolor=theme.CARD, edgecolor=theme.RULE if axis else theme.CARD, linewidth=0.8)
    if axis:
        _ticks(figure, axes, layout)
    return axes


def _frame(axes: Axes, layout: Layout, **look: Any) -> Rectangle:
    """Add a rectangle as large as the world."""
    x_min, y_min, x_max, y_max = layout.bounds
    rectangle = Rectangle((x_min, y_min), x_max - x_min, y_max - y_min, **look)
    axes.add_patch(rectangle)
    return rectangle


def _ticks(figure: Figure, axes: Axes, layout: Layout) -> None:
    """Write the coordinates beside the drawing area and draw the grid; the last number bears the unit."""
    x_min, y_min, x_max, y_max = layout.bounds
    common: dict[str, Any] = {
        "family": theme.FONT,
        "fontsize": 7.5,
        "color": theme.INK_LIGHT,
        "parse_math": False,
        "usetex": False,
    }
    columns = tick_positions(x_min, x_max, layout.plot_width / layout.enlargement)
    rows = tick_positions(y_min, y_max, layout.plot_height / layout.enlargement)
    low, low_row = layout.column_row(x_min, y_min)
    gap = 6.0 * layout.enlargement
    for x in columns:
        axes.plot([x, x], [y_min, y_max], color=theme.GRID, linewidth=0.7)
        column, _ = layout.column_row(x, y_min)
        words = _number(x) + (" m" if x == columns[-1] else "")
        place = column / layout.width, 1.0 - (low_row + gap) / layout.height
        figure.text(*place, words, ha="center", va="top", **common)
    for y in rows:
        axes.plot([x_min, x_max], [y, y], color=theme.GRID, linewidth=0.7)
        _, row = layout.column_row(x_min, y)
        figure.text(
            (low - gap) / layout.width, 1.0 - row / layout.height, _number(y), ha="right", va="center", **common
        )


def _number(value: float) -> str:
    return f"{round(value, 9) + 0.0:g}".replace("-", "\N{MINUS SIGN}")


def _without_alpha(rgba: Bytes) -> Bytes:
    """Copy the colours of an opaque picture; channel by channel, which is four times as fast as one slice."""
    rgb = np.empty((*rgba.shape[:2], 3), np.uint8)
    for channel in range(3):
        rgb[..., channel] = rgba[..., channel]
    return rgb
