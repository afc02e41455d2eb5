"""Matplotlib paths of what a scene holds."""

from __future__ import annotations

import functools
import math

import numpy as np
from matplotlib.path import Path

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.render import theme
from irsim_gym.render.scene import BodyView, FieldView, ScanView

FULL_TURN = 2.0 * np.pi - 0.01
FLATNESS = 0.4
"""Eight times how far an arc may be from the lines that stand for it [pixel]."""
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


def is_plain(view: BodyView) -> bool:
    """Return whether a footprint is a single closed way with a plain edge."""
    if view.style.line_style != "solid" or len(view.lines) + len(view.discs) != 1:
        return False
    return bool(len(view.discs)) or _is_closed(view.lines[0])


def corners(view: BodyView, scale: float) -> Floats:
    """Return the corners of such a footprint, where ``scale`` pixels are a metre."""
    if view.lines:
        return view.lines[0][:-1]
    x, y, radius = view.discs[0].tolist()
    return disc(x, y, radius, scale)


def disc(x: float, y: float, radius: float, scale: float) -> Floats:
    """Return the corners of a polygon that cannot be told from a disc, where ``scale`` pixels are a metre."""
    count = 16 * math.ceil(min(0.45 * math.sqrt(radius * scale), 16.0))
    return np.asarray(_circle(count) * radius + np.array([x, y]), np.float64)


def goal_arrow(x: float, y: float, radius: float, heading: float, metre: float) -> Floats:
    """Return the corners of the arrow that shows where a body has to head at its goal [m].

    Args:
        x: The goal.
        y: The goal.
        radius: Radius of its circle.
        heading: Direction [rad].
        metre: Metres in a point of type.
    """
    least, head, wide, thin = (size * metre for size in theme.GOAL_ARROW)
    neck = max(radius, least)
    corners = [(0.0, thin), (neck, thin), (neck, wide), (neck + head, 0.0), (neck, -wide), (neck, -thin), (0.0, -thin)]
    cosine, sine = math.cos(heading), math.sin(heading)
    return np.asarray(np.array(corners) @ np.array([[cosine, sine], [-sine, cosine]]) + np.array([x, y]), np.float64)


@functools.lru_cache(maxsize=64)
def _sector(span: float, count: int) -> Floats:
    """Return the corners of a sector with its middle ahead and a radius of one."""
    angles = np.linspace(-0.5, 0.5, count + 1) * span
    return np.vstack([np.zeros((1, 2)), np.column_stack([np.cos(angles), np.sin(angles)])])


@functools.lru_cache(maxsize=16)
def _circle(count: int) -> Floats:
    angles = np.linspace(0.0, 2.0 * np.pi, count + 1)[:-1]
    return np.column_stack([np.cos(angles), np.sin(angles)])


def sector(view: FieldView, scale: float) -> Floats:
    """Return the corners of a field of view: a sector, or a disc when it is a full turn wide."""
    if view.span >= FULL_TURN:
        return disc(view.x, view.y, view.radius, scale)
    count = math.ceil(view.span * math.sqrt(max(view.radius * scale, 1.0) / FLATNESS)) + 1
    across, up = view.radius * math.cos(view.heading), view.radius * math.sin(view.heading)
    return np.asarray(_sector(view.span, count) @ np.array([[across, up], [-up, across]]) + (view.x, view.y))


def beams(view: ScanView) -> list[Floats]:
    """Return both ends of each beam; of many every n-th."""
    return rays(view.origin, view.ends[:: -(-len(view.ends) // MOST_BEAMS)])


def rays(origin: Floats, ends: Floats) -> list[Floats]:
    """Return the lines from a point to others, each of shape ``(2, 2)``."""
    lines = np.empty((len(ends), 2, 2))
    lines[:, 0], lines[:, 1] = origin, ends
    return list(lines)


def seen(view: ScanView) -> Floats:
    """Return the corners of the area that a scan sees."""
    return view.ends if view.surrounds else np.vstack([view.origin, view.ends])


def thinned(points: Floats, apart: float) -> Floats:
    """Leave out points that stand closer than ``apart`` [m] along the way."""
    if len(points) < 3:
        return points
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    bins = np.floor(along / apart)
    kept: Flags = np.concatenate([[True], np.diff(bins) > 0])
    kept[-1] = True
    return np.asarray(points[kept], np.float64)
