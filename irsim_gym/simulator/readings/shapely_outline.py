"""Outlines as shapely geometries."""

import math
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats


def shapely_outline(segments: Floats, discs: Floats, *, solid: bool) -> Any:
    """Return an outline as a shapely geometry: an area, or a line where it has none.

    A disc is a polygon of 64 corners, as in IR-SIM.

    Args:
        segments: x0, y0, x1, y1 of each segment [m], shape ``(n, 4)``.
        discs: x, y, radius of each disc [m], shape ``(n, 3)``.
        solid: The segments bound an area: outer rings counter-clockwise, holes clockwise.
    """
    import shapely

    breaks = np.flatnonzero((segments[1:, :2] != segments[:-1, 2:]).any(axis=1)) + 1
    chains = [part for part in np.split(segments, breaks) if len(part)]
    if not solid:
        return shapely.LineString(np.vstack([segments[:, :2], segments[-1:, 2:]]))
    rings = [shapely.Polygon(part[:, :2]) for part in chains]
    if len(rings) + len(discs) == 1 and rings:
        return rings[0]
    areas = [ring for ring in rings if ring.exterior.is_ccw]
    holes = [ring for ring in rings if not ring.exterior.is_ccw]
    rounds = [shapely.Point(x, y).buffer(radius) for x, y, radius in discs]
    return rounds[0] if not rings and len(rounds) == 1 else _joined([*areas, *rounds], holes)


def _joined(areas: list[Any], holes: list[Any]) -> Any:
    import shapely

    solid = shapely.union_all(areas)
    return shapely.difference(solid, shapely.union_all(holes)) if holes else solid


def moved(geometry: Any, x: float, y: float, heading: float) -> Any:
    """Return a shapely geometry turned by a heading [rad] and then moved [m]."""
    from shapely.affinity import affine_transform

    cosine, sine = math.cos(heading), math.sin(heading)
    return affine_transform(geometry, [cosine, -sine, sine, cosine, x, y])


def shapely_cells(occupied: Flags, left: float, bottom: float, width: float, height: float) -> Any:
    """Return the boundary of the occupied cells of a map as shapely lines, as IR-SIM does.

    Args:
        occupied: Whether each cell is, shape ``(columns, rows)``.
        left: x of the left edge [m].
        bottom: y of the lower edge [m].
        width: Width of a cell [m].
        height: Height of a cell [m].
    """
    import shapely

    columns, rows = np.nonzero(occupied)
    if not len(columns):
        return shapely.MultiLineString()
    x, y = left + (columns + 0.5) * width, bottom + (rows + 0.5) * height  # as IR-SIM, for equal edges
    boxes = shapely.box(x - width / 2, y - height / 2, x + width / 2, y + height / 2)
    boundary: Any = shapely.union_all(boxes).boundary
    return boundary if hasattr(boundary, "geoms") else shapely.MultiLineString([boundary])
