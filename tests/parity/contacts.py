"""Where a disc touches and ir-sim's polygon of 64 corners does not yet."""

from __future__ import annotations

from typing import Any

import shapely
from exact import largest_disc

INSET = 0.0013
TOUCH = 1e-9


def grazes(pair: Any, b: int, skip: set[int]) -> bool:
    """Return whether the body is so near another that its exact disc may touch it while the polygon does not.

    A polygon of 64 corners lies up to 0.0012 r inside its disc, measured towards the centre; bodies that just touch may
    fall to either side.
    """
    objects = pair.reference.objects
    one = objects[b]
    for q, other in enumerate(objects):
        if q == b or other.unobstructed or one.unobstructed or q in skip:
            continue
        gap = shapely.distance(one._geometry, other._geometry)
        if gap <= INSET * (largest_disc(pair, b) + largest_disc(pair, q)) + TOUCH and depth(one, other) <= TOUCH:
            return True
    return False


def depth(one: Any, other: Any) -> float:
    """Return how far two bodies overlap, as the area of the intersection (its length for a line)."""
    common = shapely.intersection(one._geometry, other._geometry)
    return float(max(common.area, common.length if min(one._geometry.area, other._geometry.area) == 0.0 else 0.0))
