"""Marks of a fixed size, drawn once as masks."""

import numpy as np

from irsim_gym.rendering.frames.letters import Masks
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.raster.areas import paint_disc, paint_line, paint_polygon

WHITE = np.array([255.0, 1.0])


def dot_mask(masks: Masks, radius: float) -> int:
    """Return the mask of a dot in the middle of a pixel."""
    return masks.drawn(
        radius + 0.5, lambda canvas, middle: paint_disc(canvas, (middle + 0.5, middle + 0.5), radius, WHITE)
    )


def flag_mask(masks: Masks, point: float) -> int:
    """Return the mask of a flag's pole; the next mask is that of its pennant."""
    pole, pennant = (np.array(part) * [point, -point] for part in (theme.FLAG_POLE, theme.FLAG_PENNANT))
    number = masks.drawn(
        10.0 * point, lambda canvas, middle: paint_line(canvas, pole + middle, 0, 2, 1.3 * point, False, False, WHITE)
    )
    masks.drawn(10.0 * point, lambda canvas, middle: paint_polygon(canvas, pennant + middle, 0, 3, False, WHITE))
    return number
