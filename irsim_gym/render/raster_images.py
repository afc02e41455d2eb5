"""Images of bodies, reduced to the size that they have on a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from irsim_gym.arraytypes import Bytes, Ints
from irsim_gym.render.images import load_image
from irsim_gym.render.outlines import box
from irsim_gym.scenario.images import image_file
from irsim_gym.world.model import WorldModel

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class Images:
    """The images of a simulation's bodies at one scale.

    Attributes:
        number: Number of each body's image.
        pixels: Colours, with the opacity multiplied into them, and opacities of all images, shape ``(n_pixels, 4)``.
        rows: First entry, width and height of each image, shape ``(n_images, 3)``.

    Args:
        scenario: What is simulated.
        model: Its constants.
        scale: Pixels per metre.
    """

    def __init__(self, scenario: Scenario, model: WorldModel, scale: float) -> None:
        self.number: dict[int, int] = {}
        made: dict[tuple[str, int, int, float], int] = {}
        parts, rows = [np.zeros((0, 4), np.uint8)], np.zeros((0, 3), np.int64)
        for body, spec in enumerate(scenario.bodies):
            size = _size(model, body, scale)
            if spec.description is None or size is None:
                continue
            pixels = load_image(image_file(spec.description, scenario.file))
            size = min(size[0], pixels.shape[1]), min(size[1], pixels.shape[0])
            key = (spec.description, *size, float(spec.plot.obj_alpha))
            if key not in made:
                made[key] = len(rows)
                rows = np.vstack([rows, [[sum(map(len, parts)), *size]]])
                parts.append(_reduced(pixels, size, key[3]))
            self.number[body] = made[key]
        self.pixels: Bytes = np.concatenate(parts)
        self.rows: Ints = rows


def _size(model: WorldModel, body: int, scale: float) -> tuple[int, int] | None:
    """Return length and width of a body's footprint [pixel]; None without one."""
    segment, disc = int(model.segment_start[body]), int(model.disc_start[body])
    segments = model.local_segments[0, segment : segment + int(model.segment_count[0, body])]
    extent = box(segments, model.local_discs[0, disc : disc + int(model.disc_count[0, body])])
    if extent is None:
        return None
    return max(round((extent[2] - extent[0]) * scale), 1), max(round((extent[3] - extent[1]) * scale), 1)


def _reduced(pixels: Bytes, size: tuple[int, int], alpha: float) -> Bytes:
    """Return an image of another size, with its opacity in it, shape ``(n_pixels, 4)``."""
    faded = pixels.copy()
    faded[..., 3] = np.rint(faded[..., 3] * alpha)
    image = Image.fromarray(faded).convert("RGBa").resize(size, Image.Resampling.HAMMING)
    return np.asarray(image, np.uint8).reshape(-1, 4)
