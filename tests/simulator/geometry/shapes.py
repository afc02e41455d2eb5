"""Random outlines for the tests, and the same shapes in shapely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import BodyOutline

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """An outline as the kernels take it, and as shapely takes it (``geometry`` without the discs)."""

    segments: Floats
    discs: Floats
    solid: bool
    geometry: Any

    @property
    def outline(self) -> BodyOutline:
        return BodyOutline(self.segments, 0, len(self.segments), self.discs, 0, len(self.discs), self.solid)

    def moved(self, turn: float, x: float, y: float, *, mirrored: bool = False) -> Shape:
        cosine, sine = np.cos(turn), np.sin(turn)
        matrix = np.array([[cosine, -sine], [sine, cosine]])
        if mirrored:
            matrix = matrix @ np.diag([1.0, -1.0])
        points = self.segments.reshape(-1, 2) @ matrix.T + [x, y]
        discs = np.hstack([self.discs[:, :2] @ matrix.T + [x, y], self.discs[:, 2:]])
        return Shape(points.reshape(-1, 4), discs, self.solid, None)


NO_SEGMENTS, NO_DISCS = np.zeros((0, 4)), np.zeros((0, 3))


def closed(vertices: Any) -> Floats:
    vertices = np.asarray(vertices, np.float64)
    return np.ascontiguousarray(np.hstack([vertices, np.roll(vertices, -1, axis=0)]))


def polygon(vertices: Any) -> Shape:
    return Shape(closed(vertices), NO_DISCS, True, shapely.Polygon(vertices))


def linestring(vertices: Any) -> Shape:
    vertices = np.asarray(vertices, np.float64)
    rows = np.ascontiguousarray(np.hstack([vertices[:-1], vertices[1:]]))
    return Shape(rows, NO_DISCS, False, shapely.LineString(vertices))


def disc(x: float, y: float, radius: float) -> Shape:
    return Shape(NO_SEGMENTS, np.array([[x, y, radius]]), True, shapely.Point(x, y))


def star(rng: np.random.Generator, x: float, y: float, size: float) -> Floats:
    """Return the vertices of a random simple polygon, mostly not convex, about (x, y)."""
    n = int(rng.integers(3, 9))
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, n) + np.linspace(0.0, 2e-3, n))
    radii = size * rng.uniform(0.2, 1.0, n)
    return np.stack([x + radii * np.cos(angles), y + radii * np.sin(angles)], axis=1)


def random_shape(rng: np.random.Generator, room: float = 2.0) -> Shape:
    """Return a polygon, a chain or a disc within some metres; with some luck the next one overlaps it."""
    x, y = rng.uniform(-room, room, 2)
    choice = rng.integers(0, 3)
    if choice == 0:
        return disc(x, y, rng.uniform(0.05, 1.0))
    if choice == 1:
        return linestring(rng.uniform(-1.0, 1.0, (int(rng.integers(2, 5)), 2)) + np.array([x, y]))
    found = polygon(star(rng, x, y, 1.5))
    return found if found.geometry.is_valid else random_shape(rng, room)


def radius_of(shape: Shape) -> float:
    """Return the radius of a shape that is a disc, else 0."""
    return float(shape.discs[0, 2]) if len(shape.discs) else 0.0


def random_pairs(n: int, seed: int) -> tuple[list[Shape], list[Shape], Floats]:
    """Return pairs of shapes and their true distances [m]: shapely's, less the discs' radii."""
    rng = np.random.default_rng(seed)
    first, second = [random_shape(rng) for _ in range(n)], [random_shape(rng) for _ in range(n)]
    radii = np.array([radius_of(a) + radius_of(b) for a, b in zip(first, second, strict=True)])
    between = shapely.distance([a.geometry for a in first], [b.geometry for b in second])
    return first, second, between - radii
