"""Corners of what a scene holds, for those who draw polygons."""

from __future__ import annotations

import math

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.render import theme
from irsim_gym.render.scene import BodyView, FieldView, ScanView

FULL_TURN = 2.0 * np.pi - 0.01
ARC_STEP = 0.05
"""Angle between two corners of an arc [rad]."""
MOST_BEAMS = 100
"""Of more beams than that only every n-th is drawn."""
CLOSED = 1e-6
"""A chain whose ends are nearer to each other than this is closed [m]."""


def is_closed(vertices: Floats) -> bool:
    """Return whether a chain of vertices ``(n, 2)`` ends where it begins."""
    return len(vertices) > 2 and bool(np.abs(vertices[0] - vertices[-1]).max() < CLOSED)


def is_filled(view: BodyView) -> bool:
    """Return whether a body is drawn as an area rather than a curve."""
    return view.style.filled and (bool(len(view.discs)) or (bool(view.lines) and view.solid))


def goal_arrow(x: float, y: float, radius: float, heading: float, metre: float) -> Floats:
    """Return the corners of the arrow that shows where a body has to head at its goal [m], shape ``(7, 2)``.

    Args:
        x: Abscissa of the goal [m].
        y: Its ordinate [m].
        radius: Radius of its circle [m].
        heading: Direction [rad].
        metre: Metres in a point of type.
    """
    least, head, wide, thin = (size * metre for size in theme.GOAL_ARROW)
    neck = max(radius, least)
    corners = [(0.0, thin), (neck, thin), (neck, wide), (neck + head, 0.0), (neck, -wide), (neck, -thin), (0.0, -thin)]
    cosine, sine = math.cos(heading), math.sin(heading)
    return np.asarray(np.array(corners) @ np.array([[cosine, sine], [-sine, cosine]]) + np.array([x, y]), np.float64)


def sector(view: FieldView) -> Floats:
    """Return the corners of a field of view [m], shape ``(n, 2)``: a sector, or a disc when it is a full turn wide."""
    angles = view.heading + np.linspace(-0.5, 0.5, max(math.ceil(view.span / ARC_STEP), 2) + 1) * view.span
    arc = np.array([view.x, view.y]) + view.radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return arc if view.span >= FULL_TURN else np.vstack([[view.x, view.y], arc])


def seen(view: ScanView) -> Floats:
    """Return the corners of the area that a scan sees [m], shape ``(n, 2)``."""
    return view.ends if view.surrounds else np.vstack([view.origin, view.ends])


def thinned(points: Floats, apart: float) -> Floats:
    """Return points ``(n, 2)`` without those that lie closer together along the way than ``apart`` [m]."""
    if len(points) < 3:
        return points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    kept = np.concatenate([[True], np.diff(np.floor(along / apart)) > 0])
    kept[-1] = True
    return np.asarray(points[kept], np.float64)
