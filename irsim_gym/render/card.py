"""The drawing area: a white card with the world's frame, a faint grid and ticks in metres."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox

from irsim_gym.render import theme
from irsim_gym.render.layout import Layout, tick_positions
from irsim_gym.render.lettering import TEXT

TICK: dict[str, Any] = {**TEXT, "fontsize": 7.5, "color": theme.INK_LIGHT}


class Area(Axes):
    """Axes whose animated artists somebody else may draw where a figure is saved, as where it is shown."""

    leaves_out_animated = False
    card: Rectangle

    def get_children(self) -> list[Artist]:
        """Return the artists that are drawn with the axes."""
        children = super().get_children()
        return [child for child in children if not child.get_animated()] if self.leaves_out_animated else children


class Play(Artist):
    """What moves, as one artist above all others of a figure that is saved."""

    zorder = 100.0

    def __init__(self, play: Callable[[RendererBase], None], extent: Callable[[RendererBase], Bbox]) -> None:
        super().__init__()
        self._play, self._extent = play, extent

    def draw(self, renderer: RendererBase) -> None:
        """Draw it."""
        self._play(renderer)

    def get_tightbbox(self, renderer: RendererBase | None = None) -> Bbox | None:
        """Return the part of the canvas that it asks for."""
        return None if renderer is None else self._extent(renderer)


def make_axes(figure: Figure, layout: Layout, axis: bool) -> Area:
    """Add the drawing area to a figure, without ticks."""
    place = (
        layout.left / layout.width,
        layout.bottom / layout.height,
        layout.plot_width / layout.width,
        layout.plot_height / layout.height,
    )
    axes = Area(figure, place)
    figure.add_axes(axes)
    axes.set(xticks=[], yticks=[], facecolor=theme.PAPER)
    axes.set_axis_off()
    axes.card = add_frame(
        axes, layout, facecolor=theme.CARD, edgecolor=theme.RULE if axis else theme.CARD, linewidth=0.8
    )
    return axes


def add_frame(axes: Axes, layout: Layout, **look: Any) -> Rectangle:
    """Add a rectangle as large as the world."""
    x_min, y_min, x_max, y_max = layout.bounds
    rectangle = Rectangle((x_min, y_min), x_max - x_min, y_max - y_min, **look)
    axes.add_patch(rectangle)
    return rectangle


class Ticks:
    """Coordinates beside the drawing area and the grid; the last number bears the unit."""

    def __init__(self, figure: Figure, axes: Axes) -> None:
        self._figure, self._axes = figure, axes
        self._shown: list[Any] = []

    def update(self, layout: Layout) -> None:
        """Show the ticks of the part of the world that a layout shows."""
        for artist in self._shown:
            artist.remove()
        x_min, y_min, x_max, y_max = layout.bounds
        left, below, right, above = layout.limits
        low, high = (max(x_min, left), max(y_min, below)), (min(x_max, right), min(y_max, above))
        self._shown = []
        if low[0] <= high[0] and low[1] <= high[1]:
            self._columns(layout, low, high)
            self._rows(layout, low, high)

    def _columns(self, layout: Layout, low: tuple[float, float], high: tuple[float, float]) -> None:
        columns = tick_positions(low[0], high[0], layout.plot_width / layout.enlargement)
        gap = 6.0 * layout.enlargement
        for x in columns:
            self._shown += self._axes.plot([x, x], [low[1], high[1]], color=theme.GRID, linewidth=0.7)
            column, row = layout.column_row(x, low[1])
            words = number_text(x) + (" m" if x == columns[-1] else "")
            place = column / layout.width, 1.0 - (row + gap) / layout.height
            self._shown.append(self._figure.text(*place, words, ha="center", va="top", **TICK))

    def _rows(self, layout: Layout, low: tuple[float, float], high: tuple[float, float]) -> None:
        gap = 6.0 * layout.enlargement
        for y in tick_positions(low[1], high[1], layout.plot_height / layout.enlargement):
            self._shown += self._axes.plot([low[0], high[0]], [y, y], color=theme.GRID, linewidth=0.7)
            column, row = layout.column_row(low[0], y)
            place = (column - gap) / layout.width, 1.0 - row / layout.height
            self._shown.append(self._figure.text(*place, number_text(y), ha="right", va="center", **TICK))


def number_text(value: float) -> str:
    """Return a coordinate as it is written beside the drawing area."""
    return f"{round(value, 9) + 0.0:g}".replace("-", "\N{MINUS SIGN}")
