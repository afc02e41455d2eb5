"""Rooms for the tests of rays, and what a textbook says that beams meet in them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.simulator.geometry.shapes import closed, star

N_BEAMS = 192
GRAZING = 2e-5
"""A beam whose result changes when it is turned by this angle [rad] grazes an end or a tangent."""


def beams(n: int = N_BEAMS) -> NDArray[np.float64]:
    return np.linspace(-np.pi, np.pi, n)


def textbook(segments: Any, discs: Any, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the same in float64: parameters of line-line and line-circle intersections."""
    ranges = np.full(len(angles), np.inf)
    x, y = np.cos(angles), np.sin(angles)
    for ax, ay, bx, by in np.asarray(segments, np.float32).astype(np.float64).reshape(-1, 4):
        along_x, along_y = bx - ax, by - ay
        across = x * along_y - y * along_x
        safe = np.where(across == 0.0, 1.0, across)
        t, u = (ax * along_y - ay * along_x) / safe, (ax * y - ay * x) / safe
        hits = (across != 0.0) & (t >= 0.0) & (u >= 0.0) & (u <= 1.0)
        ranges = np.where(hits, np.minimum(ranges, t), ranges)
    for cx, cy, radius in np.asarray(discs, np.float32).astype(np.float64).reshape(-1, 3):
        ahead, aside = cx * x + cy * y, cx * y - cy * x
        room = radius * radius - aside * aside
        root = np.sqrt(np.maximum(room, 0.0))
        t = ahead + (root if cx * cx + cy * cy < radius * radius else -root)
        ranges = np.where((room >= 0.0) & (t >= 0.0), np.minimum(ranges, t), ranges)
    return ranges


def random_room(rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return segments and discs about the origin, some of which may hold it."""
    parts = [closed(star(rng, *rng.uniform(-8.0, 8.0, 2), 1.0)) for _ in range(8)]
    walls = closed([[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]])
    discs = np.hstack([rng.uniform(-6.0, 6.0, (6, 2)), rng.uniform(0.1, 0.8, (6, 1))])
    return np.vstack([*parts, walls]), discs


def steady(segments: Any, discs: Any, angles: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which beams keep their range (to 1 mm) when turned a little, so that they graze nothing."""
    here, left, right = (textbook(segments, discs, angles + turn) for turn in (0.0, GRAZING, -GRAZING))
    return np.asarray((abs(left - here) < 1e-3) & (abs(right - here) < 1e-3))
