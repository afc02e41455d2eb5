"""Matplotlib paths of what a scene holds."""

from __future__ import annotations

import numpy as np
from matplotlib.path import Path

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.render.scene import BodyView, FieldView, ScanView

FULL_TURN = 2.0 * np.pi - 0.01
ARC_STEP = 0.05
MOST_BEAMS = 100
CIRCLE_VERTICES: Floats = np.asarray(Path.unit_circle().vertices, np.float64)
CIRCLE_CODES = Path.unit_circle().codes


def outline_path(view: BodyView) -> Path:
    """Return a body's footprint as one path: its chains, then its discs."""
    parts = [_chain(line) for line in view.lines] + [circle_path(x, y, radius) for x, y, radius in view.discs]
    return parts[0] if len(parts) == 1 else Path.make_compound_path(*parts)


def _chain(vertices: Floats) -> Path:
    return Path(vertices, closed=_is_closed(vertices))


def _is_closed(vertices: Floats) -> bool:
    return len(vertices) > 2 and bool(np.abs(vertices[0] - vertices[-1]).max() < 1e-6)


def is_filled(view: BodyView) -> bool:
    """Return whether a body is drawn as an area rather than a curve."""
    return view.style.filled and (bool(len(view.discs)) or (bool(view.lines) and view.solid))


def circle_path(x: float, y: float, radius: float) -> Path:
    """Return a circle."""
    return Path(CIRCLE_VERTICES * radius + np.array([x, y]), CIRCLE_CODES)


def sector_path(view: FieldView) -> Path:
    """Return a field of view: a sector, or a circle when it is a full turn wide."""
    if view.span >= FULL_TURN:
        return circle_path(view.x, view.y, view.radius)
    angles = view.heading + np.linspace(-0.5, 0.5, max(int(view.span / ARC_STEP), 2) + 1) * view.span
    arc = view.radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Path(np.vstack([np.zeros((1, 2)), arc, np.zeros((1, 2))]) + np.array([view.x, view.y]), closed=True)


def beam_path(view: ScanView) -> Path:
    """Return the beams as one path, so that where they overlap they are not darker; of many every n-th."""
    ends = view.ends[:: -(-len(view.ends) // MOST_BEAMS)]
    return rays_path(view.origin, ends)


def rays_path(origin: Floats, ends: Floats) -> Path:
    """Return the lines from a point to others as one path."""
    vertices = np.empty((2 * len(ends), 2))
    vertices[0::2] = origin
    vertices[1::2] = ends
    codes = np.tile(np.array([Path.MOVETO, Path.LINETO], Path.code_type), len(ends))
    return Path(vertices, codes)


def seen_path(view: ScanView) -> Path:
    """Return the border of the area that a scan sees."""
    corners = view.ends if view.surrounds else np.vstack([view.origin, view.ends])
    return Path(np.vstack([corners, corners[:1]]), closed=True)


def thinned(points: Floats, apart: float) -> Floats:
    """Leave out points that stand closer than ``apart`` [m] along the way."""
    if len(points) < 3:
        return points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    bins = np.floor(along / apart)
    kept: Flags = np.concatenate([[True], np.diff(bins) > 0])
    kept[-1] = True
    return np.asarray(points[kept], np.float64)
