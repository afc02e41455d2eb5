"""The boundary of a footprint in the body's own frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from irsim_gym.arraytypes import Floats


@dataclass(frozen=True)
class Outline:
    """Segments and discs that make up a footprint.

    Attributes:
        segments: x0, y0, x1, y1 of each segment [m], shape ``(n_segments, 4)``.
        discs: x, y, radius of each disc [m], shape ``(n_discs, 3)``.
        solid: The segments are the closed boundary of an area, not a curve.
        centroid: Centre of the area [m], where parts that overlap would count twice; else it is worked out.
    """

    segments: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    discs: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    solid: bool = True
    centroid: tuple[float, float] | None = None


def chain(vertices: Floats, *, closed: bool) -> Floats:
    """Return the segments that join vertices ``(n, 2)`` [m] in order, shape ``(n_segments, 4)``."""
    ends = np.roll(vertices, -1, axis=0) if closed else vertices[1:]
    starts = vertices if closed else vertices[:-1]
    return np.hstack([starts, ends])
