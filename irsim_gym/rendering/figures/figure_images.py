"""The images in figures: of bodies, maps and fog."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.image import AxesImage
from matplotlib.transforms import Affine2D

from irsim_gym.base.arraytypes import Bytes, Flags, Floats
from irsim_gym.rendering.scene.scene import FogView, ImageView, MapView


def body_image(axes: Axes, view: ImageView) -> AxesImage:
    """Return the image of a body, rotated and stretched to its footprint."""
    corner, ahead, aside = view.corners[0], view.corners[1] - view.corners[0], view.corners[3] - view.corners[0]
    turned = Affine2D(np.array([[ahead[0], aside[0], corner[0]], [ahead[1], aside[1], corner[1]], [0.0, 0.0, 1.0]]))
    pixels = view.pixels.copy()
    pixels[..., 3] = np.rint(pixels[..., 3] * view.alpha)
    return _image(axes, pixels, (0.0, 0.0, 1.0, 1.0), "bilinear", turned + axes.transData)


def map_image(axes: Axes, view: MapView) -> AxesImage:
    """Return an image of a map's occupied cells; one occupied cell fills its pixel, so that no wall is lost."""
    cells, (x_min, y_min, x_max, y_max) = view.occupied, view.extent
    size = axes.transData.transform((x_max, y_max)) - axes.transData.transform((x_min, y_min))
    wide, high = (max(int(count / side), 1) for count, side in zip(cells.shape, size.tolist(), strict=True))
    padded = np.pad(cells, ((0, -len(cells) % wide), (0, -cells.shape[1] % high)))
    coarse = padded.reshape(len(padded) // wide, wide, -1, high).any(axis=(1, 3))
    pixels = np.zeros((*coarse.T.shape, 4), np.uint8)
    pixels[np.asarray(coarse).T[::-1]] = np.rint(255.0 * np.array(to_rgba(view.colour, view.alpha)))
    right = x_min + (x_max - x_min) * padded.shape[0] / cells.shape[0]
    above = y_min + (y_max - y_min) * padded.shape[1] / cells.shape[1]
    return _image(axes, pixels, (x_min, y_min, right, above), "nearest", axes.transData)


def fog_image(axes: Axes, view: FogView) -> AxesImage:
    """Return a soft cover over unseen cells."""
    pixels = np.empty((*view.covered.T.shape, 4), np.uint8)
    pixels[..., :3] = np.rint(255.0 * np.array(to_rgb(view.colour)))
    pixels[..., 3] = np.rint(255.0 * view.alpha * _softened(view.covered).T[::-1])
    return _image(axes, pixels, view.extent, "bilinear", axes.transData)


def _softened(covered: Flags) -> Floats:
    """Return the cover of each cell: 0 for seen cells, else from the share of covered cells among its 3 x 3."""
    columns, rows = covered.shape
    padded = np.pad(covered, 1, mode="edge")
    around = sum(padded[i : i + columns, j : j + rows].astype(np.float64) for i in range(3) for j in range(3))
    return np.asarray(np.where(covered, 0.5 + around / 18.0, 0.0))


def _image(
    axes: Axes, pixels: Bytes, extent: tuple[float, float, float, float], interpolation: Any, transform: Any
) -> AxesImage:
    """Return pixels ``(height, width, 4)``, row 0 at the top, over x_min, y_min, x_max, y_max."""
    left, low, right, high = extent
    image = AxesImage(axes, interpolation=interpolation, extent=(left, right, low, high))
    image.set_data(pixels)
    image.set_transform(transform)
    return image
