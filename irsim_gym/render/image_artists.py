"""How pixels are drawn: images of bodies, and the fog over what nobody has seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.transforms import Affine2D
from PIL import Image

from irsim_gym.arraytypes import Bytes, Flags, Floats
from irsim_gym.render.brush import Brush
from irsim_gym.render.scene import BodyView, FogView, ImageView

REMEMBERED_SIZES = 64
SMOOTH = 4
"""How many times finer than its cells fog is drawn into a file that knows no pixels."""


class Images:
    """Images of bodies, turned and stretched to their footprints.

    Each is reduced to the size that it has on the canvas once; a frame only turns and shifts it.

    Args:
        axes: Where they are drawn.
    """

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._reduced: dict[tuple[int, int, int, float], tuple[Bytes, Image.Image]] = {}

    def draw(self, brush: Brush, views: Sequence[BodyView]) -> None:
        """Draw the images of these bodies, the first one lowest; bodies without one are left out."""
        for image in (view.image for view in views if view.image is not None):
            corners: Floats = brush.to_canvas.transform(image.corners)
            if brush.renderer.option_scale_image():
                _draw_scaled(brush, image, corners)
            else:
                self._draw_pixels(brush, image, corners)

    def _draw_pixels(self, brush: Brush, image: ImageView, corners: Floats) -> None:
        """Turn the image on a canvas of pixels."""
        canvas = self._axes.figure.bbox
        low = np.maximum(np.floor(corners.min(axis=0)) - 1.0, 0.0).astype(int)
        high = np.minimum(np.ceil(corners.max(axis=0)) + 1.0, [canvas.width, canvas.height]).astype(int)
        width, height = (high - low).tolist()
        if width <= 0 or height <= 0:
            return
        ahead, aside = corners[1] - corners[0], corners[3] - corners[0]
        source = self._sized(image, float(np.hypot(*ahead)), float(np.hypot(*aside)))
        columns, rows = source.width - 2, source.height - 2
        along, across = ahead / max(ahead @ ahead, 1e-12) * columns, aside / max(aside @ aside, 1e-12) * rows
        # Canvas rows go up, those of images go down; the source has a border of one clear pixel.
        start = np.array([low[0], low[1] + height]) - corners[0]
        turn = (along[0], -along[1], along @ start + 1.0, -across[0], across[1], rows - across @ start + 1.0)
        turned = source.transform((width, height), Image.Transform.AFFINE, turn, Image.Resampling.BILINEAR)
        _put(brush, float(low[0]), float(low[1]), np.asarray(turned.convert("RGBA")))

    def _sized(self, image: ImageView, length: float, width: float) -> Image.Image:
        """Return the image not larger than on the canvas, with its opacity and a border of one clear pixel."""
        rows, columns = image.pixels.shape[:2]
        size = max(min(round(length), columns), 1), max(min(round(width), rows), 1)
        key = (id(image.pixels), *size, image.alpha)
        known = self._reduced.get(key)
        if known is None:
            source = Image.fromarray(_faded(image)).convert("RGBa").resize(size, Image.Resampling.HAMMING)
            bordered = Image.new("RGBa", (size[0] + 2, size[1] + 2))
            bordered.paste(source, (1, 1))
            if len(self._reduced) >= REMEMBERED_SIZES:
                self._reduced.pop(next(iter(self._reduced)))
            known = self._reduced[key] = image.pixels, bordered  # the pixels are held, so that their id stays theirs
        return known[1]


def _draw_scaled(brush: Brush, image: ImageView, corners: Floats) -> None:
    """Hand the image itself to a format that can turn it."""
    origin, (x, y) = corners[0], (corners[1] - corners[0], corners[3] - corners[0])
    turned = Affine2D(np.array([[x[0], y[0], origin[0]], [x[1], y[1], origin[1]], [0.0, 0.0, 1.0]]))
    _put(brush, 0.0, 0.0, _faded(image), turned)


class Fog:
    """A soft cover over the cells that nobody has seen."""

    def __init__(self, axes: Axes) -> None:
        self._axes = axes

    def draw(self, brush: Brush, views: Sequence[FogView]) -> None:
        """Draw these fogs, as far as the axes show them."""
        (left, right), (below, above) = self._axes.get_xlim(), self._axes.get_ylim()
        for view in views:
            x_min, y_min, x_max, y_max = view.extent
            low = np.array([max(x_min, left), max(y_min, below)])
            high = np.array([min(x_max, right), min(y_max, above)])
            if (high > low).all():
                self._draw_part(brush, view, low, high)

    def _draw_part(self, brush: Brush, view: FogView, low: Floats, high: Floats) -> None:
        """Draw the part of a fog between two corners [m]."""
        first, last = brush.to_canvas.transform([low, high])
        cell = (np.array(view.extent[2:]) - view.extent[:2]) / view.covered.shape
        start, end = (low - view.extent[:2]) / cell, (high - view.extent[:2]) / cell
        if brush.renderer.option_scale_image():
            columns, rows = np.ceil(SMOOTH * (end - start)).astype(int).tolist()
            turned = Affine2D().scale(*(last - first)).translate(*first)
            _put(brush, 0.0, 0.0, _cover(view, start, end, columns, rows), turned)
        else:
            first, last = np.rint(first), np.rint(last)
            columns, rows = np.maximum(last - first, 1.0).astype(int).tolist()
            _put(brush, float(first[0]), float(first[1]), _cover(view, start, end, columns, rows))


def _cover(view: FogView, start: Floats, end: Floats, columns: int, rows: int) -> Bytes:
    """Return the part of a fog between two corners, counted in cells, as pixels with soft edges, row 0 at the top."""
    mask = Image.fromarray(np.rint(255.0 * view.alpha * _softened(view.covered).T).astype(np.uint8))
    part = float(start[0]), float(start[1]), float(end[0]), float(end[1])
    pixels = np.empty((rows, columns, 4), np.uint8)
    pixels[...] = [*(round(255 * level) for level in to_rgb(view.colour)), 0]
    pixels[..., 3] = np.asarray(mask.resize((columns, rows), Image.Resampling.BILINEAR, box=part))[::-1]
    return pixels


def _faded(image: ImageView) -> Bytes:
    """Return the pixels of an image with its opacity in them."""
    pixels = image.pixels.copy()
    pixels[..., 3] = np.rint(pixels[..., 3] * image.alpha)
    return pixels


def _softened(covered: Flags) -> Floats:
    """Return how much each cell is covered: seen ones not at all, others less where their neighbours have been seen."""
    columns, rows = covered.shape
    padded = np.pad(covered, 1, mode="edge")
    around = sum(padded[i : i + columns, j : j + rows].astype(np.float64) for i in range(3) for j in range(3))
    return np.asarray(np.where(covered, 0.5 + around / 18.0, 0.0))


def _put(brush: Brush, x: float, y: float, pixels: Bytes, transform: Affine2D | None = None) -> None:
    """Draw pixels, row 0 at the top, with their lower left corner at x, y on the canvas."""
    upwards = pixels[::-1].copy()  # not a view of what Pillow protects: matplotlib wants to be able to write
    if transform is None:
        brush.renderer.draw_image(brush.context, x, y, upwards)
    else:
        brush.renderer.draw_image(brush.context, x, y, upwards, transform)
