"""Converts rows of segments to drawable shapes."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.rendering.raster import records
from irsim_gym.rendering.raster.figures import load_around, load_mark

NOTHING = np.zeros((0, 2))
MOST_CORNERS = 7
AROUND = {"circle": records.CIRCLE, "rectangle": records.RECTANGLE}
"""Shapes that may stand for a footprint."""


def chains(segments: Floats) -> tuple[Floats, ...]:
    """Join consecutive segments.

    Args:
        segments: x0, y0, x1, y1 of each [m], shape ``(n_segments, 4)``.

    Returns:
        Chains of vertices [m], each of shape ``(n_vertices, 2)``; a closed one repeats its first vertex.
    """
    if not len(segments):
        return ()
    gaps = np.abs(segments[1:, :2] - segments[:-1, 2:]).max(axis=1) > 1e-6
    cuts = np.flatnonzero(gaps) + 1
    return tuple(np.vstack([part[:, :2], part[-1:, 2:]]) for part in np.split(segments, cuts))


def box(segments: Floats, discs: Floats) -> tuple[float, float, float, float] | None:
    """Return the bounding box x_min, y_min, x_max, y_max [m] of an outline; None if it is empty."""
    low = [part.min(axis=0) for part in (segments[:, :2], segments[:, 2:]) if len(part)]
    high = [part.max(axis=0) for part in (segments[:, :2], segments[:, 2:]) if len(part)]
    if len(discs):
        low.append((discs[:, :2] - discs[:, 2:]).min(axis=0))
        high.append((discs[:, :2] + discs[:, 2:]).max(axis=0))
    if not low:
        return None
    (x_min, y_min), (x_max, y_max) = np.min(low, axis=0), np.max(high, axis=0)
    return float(x_min), float(y_min), float(x_max), float(y_max)


def heading_mark(form: int, size: tuple[float, float], segments: Floats, discs: Floats) -> Floats:
    """Return the corners of the mark that shows a body's heading, in the body frame [m], shape ``(n, 2)``.

    Args:
        form: ``records.WEDGE``, ``WINDSCREEN`` or ``ARROW``.
        size: Length and width of an arrow [m].
        segments: The footprint's segments in the body frame [m], shape ``(n_segments, 4)``.
        discs: Its discs in the body frame [m], shape ``(n_discs, 3)``.
    """
    points = np.zeros((MOST_CORNERS, 2))
    count = load_mark(points, records.Mark(form, *map(float, size)), _outline(segments, discs), np.zeros(4))
    return points[:count]


def replaced(shape: str, segments: Floats, discs: Floats) -> tuple[Floats, Floats]:
    """Return segments and discs of a shape that replaces a footprint: a circle or a rectangle around it.

    For any other shape, return the footprint unchanged.
    """
    points = np.zeros((MOST_CORNERS, 2))
    if shape not in AROUND or not load_around(points, AROUND[shape], _outline(segments, discs), np.zeros(4)):
        return segments, discs
    if shape == "rectangle":
        return np.hstack([points[:4], np.roll(points[:4], -1, axis=0)]), np.zeros((0, 3))
    return np.zeros((0, 4)), np.array([[*points[0], points[1, 0]]])


def _outline(segments: Floats, discs: Floats) -> records.RasterOutline:
    return records.RasterOutline(segments, (0, len(segments)), discs, (0, len(discs)))


def placed(points: Floats, pose: Floats) -> Floats:
    """Transform points from the body frame, shape ``(n, 2)`` [m], to the world frame."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    turned: Floats = points @ np.array([[cosine, sine], [-sine, cosine]])
    return turned + pose[:2]
