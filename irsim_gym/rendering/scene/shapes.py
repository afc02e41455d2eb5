"""Converts rows of segments to drawable shapes."""

import numpy as np

from irsim_gym.base.arraytypes import Floats

NOTHING = np.zeros((0, 2))
WEDGE = np.array([[0.70, 0.0], [-0.46, 0.50], [-0.20, 0.0], [-0.46, -0.50]])


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


def wedge(segments: Floats, discs: Floats) -> Floats:
    """Return the corners of a mark inside a footprint that points ahead.

    Args:
        segments: The footprint's segments in the body frame [m], shape ``(n_segments, 4)``.
        discs: Its discs in the body frame [m], shape ``(n_discs, 3)``.

    Returns:
        Corners in the body frame [m], shape ``(4, 2)``; shape ``(0, 2)`` for an empty footprint.
    """
    extent = box(segments, discs)
    if extent is None:
        return NOTHING
    if len(discs):
        center, half = discs[0, :2], float(discs[0, 2])
    else:
        starts, sides = segments[:, :2], segments[:, 2:] - segments[:, :2]
        lengths = np.linalg.norm(sides, axis=1)
        center = np.average(starts + 0.5 * sides, axis=0, weights=lengths)
        along = np.clip(np.sum((center - starts) * sides, axis=1) / np.maximum(lengths * lengths, 1e-12), 0.0, 1.0)
        inner = float(np.linalg.norm(starts + along[:, None] * sides - center, axis=1).min())
        half = max(inner, 0.15 * min(extent[2] - extent[0], extent[3] - extent[1]))
    return np.asarray(WEDGE * half + center, np.float64)


def windscreen(segments: Floats, discs: Floats) -> Floats:
    """Return the corners of a car's windscreen, seen from above, in the body frame [m], shape ``(4, 2)``."""
    extent = box(segments, discs)
    if extent is None:
        return NOTHING
    x_min, y_min, x_max, y_max = extent
    length, middle, half = x_max - x_min, 0.5 * (y_min + y_max), 0.5 * (y_max - y_min)
    back, front = x_min + 0.56 * length, x_min + 0.74 * length
    return np.array(
        [
            [back, middle - 0.58 * half],
            [front, middle - 0.76 * half],
            [front, middle + 0.76 * half],
            [back, middle + 0.58 * half],
        ]
    )


def replaced(shape: str, segments: Floats, discs: Floats) -> tuple[Floats, Floats]:
    """Return segments and discs of a shape that replaces a footprint: a circle or a rectangle around it.

    For any other shape, return the footprint unchanged.
    """
    extent = box(segments, discs)
    if extent is None or shape not in ("circle", "rectangle"):
        return segments, discs
    x_min, y_min, x_max, y_max = extent
    if shape == "rectangle":
        corners = np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])
        return np.hstack([corners, np.roll(corners, -1, axis=0)]), np.zeros((0, 3))
    center = np.array([0.5 * (x_min + x_max), 0.5 * (y_min + y_max)])
    corners = np.vstack([segments[:, :2], segments[:, 2:]])
    radius = max(
        np.linalg.norm(corners - center, axis=1).max(initial=0.0),
        (np.linalg.norm(discs[:, :2] - center, axis=1) + discs[:, 2]).max(initial=0.0),
    )
    return np.zeros((0, 4)), np.array([[*center, radius]])


def arrow(length: float, width: float) -> Floats:
    """Return the corners of an arrow from the body's origin straight ahead, in the body frame [m], shape ``(7, 2)``."""
    neck, shaft, half = 0.55 * length, 0.14 * width, 0.5 * width
    return np.array(
        [[0.0, shaft], [neck, shaft], [neck, half], [length, 0.0], [neck, -half], [neck, -shaft], [0.0, -shaft]]
    )


def placed(points: Floats, pose: Floats) -> Floats:
    """Transform points from the body frame, shape ``(n, 2)`` [m], to the world frame."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    turned: Floats = points @ np.array([[cosine, sine], [-sine, cosine]])
    return turned + pose[:2]
