"""How bodies are drawn: footprints, headings, impacts, and the map that they stand on."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.image import AxesImage
from matplotlib.transforms import Affine2D

from irsim_gym.render import shapes, theme
from irsim_gym.render.brush import CLEAR, Brush, tint
from irsim_gym.render.image_artists import Images
from irsim_gym.render.layout import Limits
from irsim_gym.render.scene import BodyView, MapView
from irsim_gym.render.styles import BodyStyle
from irsim_gym.render.washer import Colour

SHADOWS = ((2.2, 0.05), (1.2, 0.07))
"""How far each shadow lies aside [point], and its opacity."""


class Bodies:
    """Footprints and their edges.

    Args:
        axes: Where they are drawn.
        shadows: Draw a soft shadow below them; for bodies that are drawn once, since it costs.
    """

    def __init__(self, axes: Axes, *, shadows: bool = False) -> None:
        self._shadows = SHADOWS if shadows else ()
        self._images = Images(axes)

    def draw(self, brush: Brush, views: Sequence[BodyView]) -> None:
        """Draw these bodies, the first one lowest."""
        brush.ends("round", "round")
        for shift, alpha in self._shadows:
            place = brush.to_canvas.frozen().translate(shift * brush.point, -shift * brush.point)
            for view in views:
                if view.image is None and shapes.is_filled(view):
                    self._draw_shadow(brush, view, alpha, place)
        for is_plain, run in groupby((view for view in views if view.image is None), shapes.is_plain):
            if is_plain:
                _draw_plain(brush, list(run))
            else:
                for view in run:
                    _draw_footprint(brush, view)
        self._images.draw(brush, [view for view in views if view.image is not None])

    @staticmethod
    def _draw_shadow(brush: Brush, view: BodyView, alpha: float, place: Affine2D) -> None:
        edge = tint(theme.SHADOW, 0.4 * alpha)
        brush.draw(shapes.outline_path(view), tint(theme.SHADOW, alpha), edge, 1.5, place=place)


def _draw_plain(brush: Brush, views: Sequence[BodyView]) -> None:
    """Draw footprints that are single closed ways with plain edges."""
    looks = [(view.style, shapes.is_filled(view)) for view in views]
    brush.areas(
        [shapes.corners(view, brush.scale) for view in views],
        [tint(style.colour, style.alpha) if is_filled else CLEAR for style, is_filled in looks],
        [_edge(style, is_filled=is_filled) for style, is_filled in looks],
        [style.line_width if is_filled else style.wall_width for style, is_filled in looks],
    )


def _draw_footprint(brush: Brush, view: BodyView) -> None:
    """Draw a footprint; one of several parts has no edges where they overlap."""
    style, path = view.style, shapes.outline_path(view)
    if not shapes.is_filled(view):
        brush.draw(path, None, _edge(style, is_filled=False), style.wall_width, style.line_style)
        return
    fill, edge = tint(style.colour, style.alpha), _edge(style, is_filled=True)
    if style.alpha == 1.0 and len(view.lines) + len(view.discs) > 1:
        brush.draw(path, fill, edge, 2.0 * style.line_width, style.line_style)
        brush.draw(path, fill)
    else:
        brush.draw(path, fill, edge, style.line_width, style.line_style)


class Headings:
    """Marks of where bodies head."""

    def draw(self, brush: Brush, views: Sequence[BodyView]) -> None:
        """Draw the marks of these bodies."""
        colours = [tint(view.style.arrow_colour, view.style.arrow_alpha) for view in views]
        brush.areas([view.heading for view in views], colours)


class MapImage:
    """The occupied cells of a map. Where several share a pixel, an occupied one wins, so that no wall is lost."""

    def __init__(self, axes: Axes) -> None:
        self._axes, self._scale = axes, 1.0
        self._image: Any = None
        self._shown: MapView | None = None

    def zoom(self, pixels_per_metre: float) -> None:
        """Draw at this scale."""
        if pixels_per_metre != self._scale:
            self._scale, self._shown = pixels_per_metre, None

    def draw(self, renderer: RendererBase, view: MapView) -> None:
        """Draw a map."""
        if view is not self._shown:
            self._show(view)
        self._image.draw(renderer)

    def _show(self, view: MapView) -> None:
        x_min, y_min, x_max, y_max = view.extent
        columns, rows = view.occupied.shape
        wide = max(int(columns / ((x_max - x_min) * self._scale)), 1)
        high = max(int(rows / ((y_max - y_min) * self._scale)), 1)
        padded = np.pad(view.occupied, ((0, -columns % wide), (0, -rows % high)))
        cells = padded.reshape(len(padded) // wide, wide, -1, high).any(axis=(1, 3))
        cell_x, cell_y = (x_max - x_min) / columns * wide, (y_max - y_min) / rows * high
        extent = (x_min, x_min + cell_x * cells.shape[0], y_min, y_min + cell_y * cells.shape[1])
        if self._image is not None:
            self._image.remove()
        colours = ListedColormap([(0.0, 0.0, 0.0, 0.0), to_rgba(view.colour, view.alpha)])
        self._image = AxesImage(self._axes, cmap=colours, interpolation="nearest", origin="lower", extent=extent)
        self._image.set(data=cells.T.astype(np.uint8), clim=(0, 1), animated=True)
        self._axes.add_artist(self._image)
        self._shown = view


class Touch:
    """A touch of an outcome's colour over the world.

    Args:
        bounds: The world's rectangle [m].
    """

    def __init__(self, bounds: Limits) -> None:
        x_min, y_min, x_max, y_max = bounds
        self._corners = np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])

    def draw(self, brush: Brush, colours: Sequence[str]) -> None:
        """Draw it."""
        brush.areas([self._corners] * len(colours), [tint(colour, 0.07) for colour in colours])


class Impacts:
    """A red edge around bodies that collide."""

    def draw(self, brush: Brush, views: Sequence[BodyView]) -> None:
        """Draw these bodies as colliding."""
        brush.ends("round", "round")
        for view in views:
            path = shapes.outline_path(view)
            brush.draw(path, None, tint(theme.IMPACT, 0.25), 5.0)
            brush.draw(path, None, tint(theme.IMPACT, 1.0), 1.8)


def _edge(style: BodyStyle, *, is_filled: bool) -> Colour:
    """Return the colour of the edge: a line's own, or a darker shade of the fill."""
    if style.edge_colour is not None:
        return tint(style.edge_colour, style.alpha)
    red, green, blue, alpha = tint(style.colour, style.alpha)
    return (0.68 * red, 0.68 * green, 0.68 * blue, alpha) if is_filled else (red, green, blue, alpha)
