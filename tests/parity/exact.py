"""The bodies of ir-sim with exact discs in place of polygons of 64 corners."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import shapely
from shapely import affinity


class Body(NamedTuple):
    """A body in the world frame.

    Attributes:
        discs: x, y, radius [m] of its circles.
        lines: What else it consists of, None when that is all.
    """

    discs: list[tuple[float, float, float]]
    lines: Any


def body_of(pair: Any, b: int) -> Body:
    """Return an object of ir-sim with exact discs."""
    theirs = pair.reference.objects[b]
    if theirs.shape == "circle":
        x, y = shapely.get_coordinates(theirs._geometry)[:-1].mean(axis=0)
        return Body([(float(x), float(y), float(theirs.gf.radius))], None)
    if theirs.shape != "compound":
        return Body([], theirs._geometry)
    x, y, heading = theirs.state[:3, 0]
    parts = pair.sim.scenario.bodies[b].shape.parts
    discs = [part.disc() for part in parts if part.name == "circle"]
    cosine, sine = np.cos(heading), np.sin(heading)
    placed = [(x + cosine * cx - sine * cy, y + sine * cx + cosine * cy, radius) for cx, cy, radius in discs]
    others = shapely.union_all([shapely.Polygon(part.corners()) for part in parts if part.name != "circle"])
    lines = affinity.translate(affinity.rotate(others, heading, origin=(0, 0), use_radians=True), x, y)
    return Body(placed, None if lines.is_empty else lines)


def largest_disc(pair: Any, b: int) -> float:
    """Return the largest radius among the body's circles, 0 without any."""
    return max((radius for _, _, radius in body_of(pair, b).discs), default=0.0)
