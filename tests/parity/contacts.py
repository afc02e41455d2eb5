"""Where a disc touches and ir-sim's polygon of 64 corners does not yet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import shapely

INSET = 0.0013
TOUCH = 1e-9


def grazes(objects: Sequence[Any], b: int, skip: set[int]) -> bool:
    """Return whether the body is so near another that its exact disc may touch it while the polygon does not.

    A polygon of 64 corners lies up to 0.0012 r inside its disc; bodies that just touch may fall to either side.
    """
    one = objects[b]
    for q, other in enumerate(objects):
        if q == b or other.unobstructed or one.unobstructed or q in skip:
            continue
        gap = shapely.distance(one._geometry, other._geometry)
        if gap <= INSET * (disc_radius(one) + disc_radius(other)) + TOUCH and depth(one, other) <= TOUCH:
            return True
    return False


def disc_radius(one: Any) -> float:
    """Return the radius of a circle, the largest one of a compound, 0 for any other shape."""
    if one.shape == "compound":
        return max((float(part.get("radius", 0.2)) for part in one.gf.parts if part["name"] == "circle"), default=0.0)
    return float(one.gf.radius) if one.shape == "circle" else 0.0


def depth(one: Any, other: Any) -> float:
    """Return how far two bodies overlap, as the area of the intersection (its length for a line)."""
    common = shapely.intersection(one._geometry, other._geometry)
    return float(max(common.area, common.length if min(one._geometry.area, other._geometry.area) == 0.0 else 0.0))
