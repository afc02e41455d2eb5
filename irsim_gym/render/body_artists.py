"""Matplotlib artists of bodies: footprints, headings, impacts, and the map that they stand on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.image import AxesImage
from matplotlib.path import Path
from matplotlib.transforms import ScaledTranslation

from irsim_gym.render import shapes, theme
from irsim_gym.render.image_artists import Images
from irsim_gym.render.patches import Colour, empty_collection, paint
from irsim_gym.render.scene import BodyView, MapView
from irsim_gym.render.styles import BodyStyle

NONE: Colour = (0.0, 0.0, 0.0, 0.0)


class Bodies:
    """Footprints and their edges.

    Args:
        axes: Where they are drawn.
        shadows: Draw a soft shadow below them; for bodies that are drawn once, since it costs.
    """

    def __init__(self, axes: Axes, *, shadows: bool = False) -> None:
        self._shadows = (
            [_shadow(axes, pixels, alpha) for pixels, alpha in ((2.2, 0.05), (1.2, 0.07))] if shadows else []
        )
        self._footprints = empty_collection(axes)
        self._images = Images(axes)

    def update(self, views: Sequence[BodyView]) -> None:
        """Show these bodies, the first one lowest; one of several parts has no edges where they overlap."""
        paths, fills, edges, widths, styles = [], [], [], [], []
        self._images.update(views)
        for view in (view for view in views if view.image is None):
            style, path, is_filled = view.style, shapes.outline_path(view), shapes.is_filled(view)
            in_parts = is_filled and style.alpha == 1.0 and len(view.lines) + len(view.discs) > 1
            width = style.line_width if is_filled else style.wall_width
            for edge, line in ((_edge(style, is_filled), 2.0 * width), (NONE, 0.0))[: 1 + in_parts]:
                paths.append(path)
                fills.append(_fill(style) if is_filled else NONE)
                edges.append(edge)
                widths.append(line if in_parts else width)
                styles.append(style.line_style)
        for shadow in self._shadows:
            shadow.set_paths([path for path, fill in zip(paths, fills, strict=True) if fill is not NONE])
        self._footprints.set_paths(paths)
        paint(self._footprints, fills, edges)
        self._footprints.set_linewidths(widths)
        self._footprints.set_linestyles(styles or ["solid"])

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        for shadow in self._shadows:
            shadow.draw(renderer)
        self._footprints.draw(renderer)
        self._images.draw(renderer)


class Headings:
    """Marks of where bodies head."""

    def __init__(self, axes: Axes) -> None:
        self._marks = empty_collection(axes)

    def update(self, views: Sequence[BodyView]) -> None:
        """Show the marks of these bodies."""
        self._marks.set_paths([Path(np.vstack([view.heading, view.heading[:1]]), closed=True) for view in views])
        colours = [to_rgba(view.style.arrow_colour, view.style.arrow_alpha * view.style.alpha) for view in views]
        paint(self._marks, colours, [(0.0,) * 4] * len(colours))

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        self._marks.draw(renderer)


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


class Impacts:
    """A red edge around bodies that collide."""

    def __init__(self, axes: Axes) -> None:
        self._edges = empty_collection(axes)
        self._edges.set_linewidths([5.0, 1.8])

    def update(self, views: Sequence[BodyView]) -> None:
        """Show these bodies as colliding."""
        paths = [shapes.outline_path(view) for view in views]
        self._edges.set_paths([path for path in paths for _ in range(2)])
        colours = [to_rgba(theme.IMPACT, 0.25), to_rgba(theme.IMPACT, 1.0)]
        paint(self._edges, [(0.0,) * 4], colours)

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        self._edges.draw(renderer)


def _fill(style: BodyStyle) -> Colour:
    return to_rgba(style.colour, style.alpha)


def _edge(style: BodyStyle, is_filled: bool) -> Colour:
    """Return the colour of the edge: a line's own, or a darker shade of the fill."""
    if style.edge_colour is not None:
        return to_rgba(style.edge_colour, style.alpha)
    red, green, blue, alpha = to_rgba(style.colour, style.alpha)
    return (0.68 * red, 0.68 * green, 0.68 * blue, alpha) if is_filled else (red, green, blue, alpha)


def _shadow(axes: Axes, pixels: float, alpha: float) -> Any:
    collection = empty_collection(axes)
    shift = pixels / 72.0
    collection.set_transform(axes.transData + ScaledTranslation(shift, -shift, axes.figure.dpi_scale_trans))
    paint(collection, [to_rgba(theme.SHADOW, alpha)], [to_rgba(theme.SHADOW, 0.4 * alpha)])
    collection.set_linewidths([1.5])
    return collection
