"""Images of bodies, reduced to their size on a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from irsim_gym.base.arraytypes import Bytes, Ints
from irsim_gym.rendering.looks.images import load_image
from irsim_gym.rendering.scene.shapes import box
from irsim_gym.scenario.specs.library import asset
from irsim_gym.simulator.world.outline import Outline

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.spec import Scenario


class Images:
    """The images of a simulation's bodies at one scale.

    Attributes:
        number: Number of each body's image.
        pixels: Colours, premultiplied with the opacity, and opacities of all images, shape ``(n_pixels, 4)``.
        rows: First entry, width and height of each image, shape ``(n_images, 3)``.

    Args:
        scenario: The scenario.
        scale: Pixels per metre.
    """

    def __init__(self, scenario: Scenario, scale: float) -> None:
        self.number: dict[int, int] = {}
        made: dict[tuple[str, int, int, float], int] = {}
        parts, rows = [np.zeros((0, 4), np.uint8)], np.zeros((0, 3), np.int64)
        for body, spec in enumerate(scenario.bodies):
            size = None if spec.description is None else _size(spec.shape.outline(), scale)
            if spec.description is None or size is None:
                continue
            pixels = load_image(asset("images", spec.description, scenario.file))
            size = min(size[0], pixels.shape[1]), min(size[1], pixels.shape[0])
            key = (spec.description, *size, float(spec.plot.obj_alpha))
            if key not in made:
                made[key] = len(rows)
                rows = np.vstack([rows, [[sum(map(len, parts)), *size]]])
                parts.append(_reduced(pixels, size, key[3]))
            self.number[body] = made[key]
        self.pixels: Bytes = np.concatenate(parts)
        self.rows: Ints = rows


def _size(outline: Outline, scale: float) -> tuple[int, int] | None:
    """Return length and width of a footprint [pixel], the largest of all levels; None for an empty footprint."""
    extent = box(outline.segments, outline.discs)
    if extent is None:
        return None
    return max(round((extent[2] - extent[0]) * scale), 1), max(round((extent[3] - extent[1]) * scale), 1)


def _reduced(pixels: Bytes, size: tuple[int, int], alpha: float) -> Bytes:
    """Return a resized image with premultiplied opacity, shape ``(n_pixels, 4)``."""
    faded = pixels.copy()
    faded[..., 3] = np.rint(faded[..., 3] * alpha)
    image = Image.fromarray(faded).convert("RGBa").resize(size, Image.Resampling.HAMMING)
    return np.asarray(image, np.uint8).reshape(-1, 4)
