"""Draws paths on a canvas of matplotlib's: a renderer and one graphics context that is set anew for every stroke.

An artist of matplotlib's makes a context, checks every option and looks up its clip for each thing that it draws, which
takes longer than the drawing itself.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backend_bases import RendererBase
from matplotlib.colors import to_rgba
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, BboxBase, IdentityTransform

from irsim_gym.arraytypes import Bytes, Floats
from irsim_gym.render.washer import Colour, Washer

CLEAR: Colour = (0.0, 0.0, 0.0, 0.0)
DASHES = {"dashed": (3.7, 1.6), "dashdot": (6.4, 1.6, 1.0, 1.6), "dotted": (1.0, 1.65)}
"""Lengths of dashes and gaps in widths of the line."""
_NOWHERE, _HERE = IdentityTransform(), np.zeros((1, 2))


@functools.lru_cache(maxsize=4096)
def tint(colour: str, alpha: float) -> Colour:
    """Return a colour with an opacity in [0, 1]."""
    return to_rgba(colour, min(alpha, 1.0))


class Brush:
    """A renderer of matplotlib's, and where the world is on its canvas.

    Args:
        renderer: The renderer.
        to_canvas: From metres to the canvas' units.
        box: Where the world is that is shown.
        wide_box: The same, wide enough for a wall along the border.
        keeps_strips: Draw texts once and keep them as pixels.
        washes: The canvas has pixels, all opaque, which kernels may paint.

    Attributes:
        renderer: The renderer.
        context: Its graphics context.
        to_canvas: From metres to the canvas' units: pixels, or those of a file.
        box: Where the world is that is shown.
        wide_box: The same, wide enough for a wall along the border.
        corner: The figure's lower left corner on the canvas; another one than 0, 0 where empty margins are left out.
        scale: Units of the canvas in a metre.
        point: Units of the canvas in a point of type.
        washer: Who paints translucent areas faster than the renderer; None where the canvas has no pixels.
        keeps_strips: Texts are drawn once and kept as pixels.
    """

    def __init__(
        self,
        renderer: RendererBase,
        to_canvas: Affine2D,
        box: BboxBase,
        wide_box: BboxBase,
        *,
        keeps_strips: bool = False,
        washes: bool = False,
    ) -> None:
        canvas: Any = renderer
        self.renderer: RendererBase = canvas
        self.to_canvas, self.keeps_strips = to_canvas, keeps_strips
        self.washer = Washer(renderer, to_canvas) if washes else None
        self.box, self.wide_box, self.corner = box, wide_box, (0.0, 0.0)
        self.context: Any = renderer.new_gc()
        self.scale = float(to_canvas.get_matrix()[0, 0])
        self.point = float(canvas.points_to_pixels(1.0))
        self._style: tuple[str, float] = ("solid", 0.0)
        self.ends("butt", "round")

    def cut(self, box: BboxBase) -> None:
        """Draw nothing outside of a box on the canvas from now on."""
        self.context.set_clip_rectangle(box)

    def ends(self, cap: str, join: str) -> None:
        """Draw lines with such ends and corners from now on, in matplotlib's words."""
        self.context.set_capstyle(cap)
        self.context.set_joinstyle(join)

    def draw(
        self,
        path: Path,
        fill: Colour | None,
        edge: Colour = CLEAR,
        width: float = 0.0,
        style: str = "solid",
        place: Affine2D | None = None,
    ) -> None:
        """Draw a path.

        Args:
            path: The path.
            fill: Colour of its area; None for a line.
            edge: Colour of its line.
            width: Width of the line [point].
            style: ``solid``, ``dashed``, ``dashdot`` or ``dotted``.
            place: From the path's coordinates to the canvas; None for those of the world.
        """
        context = self.context
        context.set_foreground(edge, isRGBA=True)
        context.set_linewidth(width if edge[3] > 0.0 else 0.0)
        if self._style != (style, width) and (style != "solid" or self._style[0] != "solid"):
            context.set_dashes(*_dashes(style, width))
            self._style = style, width
        area = fill if fill is not None and fill[3] > 0.0 else None
        self.renderer.draw_path(context, path, self.to_canvas if place is None else place, area)

    def areas(
        self,
        ways: Sequence[Floats],
        fills: Sequence[Colour],
        edges: Sequence[Colour] = (),
        widths: Sequence[float] = (),
    ) -> None:
        """Draw polygons, one after another.

        Args:
            ways: Their corners [m], shape ``(n, 2)``; the last one need not repeat the first.
            fills: Their colours.
            edges: Colours of their edges; nothing for no edges.
            widths: Widths of these edges [point].
        """
        edges, widths = edges or [CLEAR] * len(fills), widths or [0.0] * len(fills)
        if self.washer is not None:
            box = self.context.get_clip_rectangle()
            self.washer.areas(box, ways, fills, edges, [width * self.point for width in widths])
            return
        for way, fill, edge, width in zip(ways, fills, edges, widths, strict=True):
            self.draw(Path(np.concatenate([way, way[:1]]), closed=True), fill, edge, width)

    def bundles(self, bundles: Sequence[Sequence[Floats]], colours: Sequence[Colour], width: float) -> None:
        """Draw bundles of lines; within a bundle they are not darker where they overlap.

        Args:
            bundles: The points of each of their lines [m], shape ``(n, 2)``.
            colours: Colours of the bundles.
            width: Width of the lines [point].
        """
        if self.washer is not None:
            self.washer.lines(self.context.get_clip_rectangle(), bundles, colours, width * self.point)
            return
        for ways, colour in zip(bundles, colours, strict=True):
            if ways:
                self.draw(Path.make_compound_path(*map(Path, ways)), None, colour, width)

    def lines(
        self, paths: Sequence[Path], colours: Sequence[Colour], widths: Sequence[float], styles: Sequence[str]
    ) -> None:
        """Draw lines [m], each with its colour, width [point] and style."""
        dashes = [_dashes(style, width) for style, width in zip(styles, widths, strict=True)]
        canvas: Any = self.renderer
        canvas.draw_path_collection(
            self.context,
            self.to_canvas,
            paths,
            np.empty((0, 3, 3)),
            _HERE,
            _NOWHERE,
            np.empty((0, 4)),
            np.array(colours),
            widths,
            dashes,
            [True],
            [None],
            "screen",
        )

    def strip(self, pixels: Bytes, column: int, row: int) -> None:
        """Put pixels ``(height, width, 4)``, the lowest row first, where their lower left corner belongs."""
        if self.washer is not None:
            self.washer.strip(self.context.get_clip_rectangle(), pixels, column, row)
        else:
            self.renderer.draw_image(self.context, column, row, pixels)

    def dots(self, places: Floats, radius: float, colour: Colour) -> None:
        """Draw discs of one radius [point] at some points [m], shape ``(n, 2)``."""
        context = self.context
        context.set_linewidth(0.0)
        context.set_snap(False)
        mark = Affine2D().scale(radius * self.point)
        self.renderer.draw_markers(context, Path.unit_circle(), mark, Path(places), self.to_canvas, colour)
        context.set_snap(None)


@functools.lru_cache(maxsize=1024)
def _dashes(style: str, width: float) -> tuple[float, tuple[float, ...] | None]:
    """Return offset and lengths of dashes [point] as a graphics context wants them; none for a line without width."""
    if style == "solid" or width <= 0.0:
        return 0.0, None
    return 0.0, tuple(length * width for length in DASHES[style])
