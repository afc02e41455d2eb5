"""Compound: the union of simpler shapes that move as one."""

from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.base.options import defaults, kind, option
from irsim_gym.bodies.shapes.circle import Circle
from irsim_gym.bodies.shapes.polygon import flaw_of
from irsim_gym.bodies.shapes.rectangle import Rectangle
from irsim_gym.simulator.world.names import Floats, Outline, Pose, chain
from irsim_gym.simulator.world.outline import CIRCLE_CORNERS

KEYS = {"circle": ("radius", "center"), "rectangle": ("length", "width"), "polygon": ("vertices",)}
"""Options of each shape of a part."""
ROUND = 128
"""Segments to a quarter of a disc where the centre of the area is computed."""


@kind
class CompoundPart:
    """One part of a compound."""

    name: Literal["circle", "rectangle", "polygon"] = option(meaning="Shape of the part.")
    pose: Pose = option((0.0, 0.0, 0.0), unit="m, m, rad", meaning="Pose of the part in the body frame.")
    radius: float | None = option(None, gt=0.0, unit="m", meaning="Radius of a circle; by default 0.2.")
    center: tuple[float, float] | None = option(None, unit="m", meaning="Centre of a circle; by default the origin.")
    length: float | None = option(None, gt=0.0, unit="m", meaning="Size of a rectangle along its x axis; by default 1.")
    width: float | None = option(None, gt=0.0, unit="m", meaning="Size of a rectangle along its y axis; by default 1.")
    vertices: tuple[tuple[float, float], ...] | None = option(
        None, min_length=3, unit="m", meaning="Corners of a polygon in the part's frame; required there."
    )

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        for name, keys in KEYS.items():
            for key in keys:
                if name != self.name and getattr(self, key) is not None:
                    yield key, f"belongs to a {name}, not to a {self.name}"
        if self.name == "polygon":
            flaw = "is required for a polygon" if self.vertices is None else flaw_of(self.vertices)
            if flaw:
                yield "vertices", flaw

    def disc(self) -> tuple[float, float, float]:
        """Return centre and radius of a circle in the body frame [m]."""
        x, y = self._placed(np.array([self.center or (0.0, 0.0)]))[0]
        return float(x), float(y), self._of(Circle, "radius")

    def corners(self) -> Floats:
        """Return the corners in the body frame [m], shape ``(n, 2)``; 64 of a circle, as IR-SIM has them."""
        if self.name == "circle":
            turns, centre = -2.0 * np.pi * np.arange(CIRCLE_CORNERS) / CIRCLE_CORNERS, self.center or (0.0, 0.0)
            rim = np.column_stack([np.cos(turns), np.sin(turns)])
            return self._placed(np.array(centre) + self._of(Circle, "radius") * rim)
        if self.name == "polygon":
            return self._placed(np.array(self.vertices, np.float64))
        right, top = self._of(Rectangle, "length") / 2.0, self._of(Rectangle, "width") / 2.0
        return self._placed(np.array([[-right, -top], [right, -top], [right, top], [-right, top]]))

    def _of(self, shape: type[Any], key: str) -> float:
        value = getattr(self, key)
        return float(getattr(defaults(shape), key) if value is None else value)

    def _placed(self, points: Floats) -> Floats:
        x, y, heading = self.pose
        cosine, sine = np.cos(heading), np.sin(heading)
        return np.stack(
            [x + cosine * points[:, 0] - sine * points[:, 1], y + sine * points[:, 0] + cosine * points[:, 1]], axis=1
        )


@kind
class Compound:
    """The union of several shapes that move as one.

    Where rectangles and polygons overlap only their common boundary is kept; circles stay exact discs beside it.
    """

    is_random: ClassVar[bool] = False

    parts: tuple[CompoundPart, ...] = option(min_length=1, meaning="The shapes.")
    wheelbase: float | None = option(None, ge=0.0, unit="m", meaning="Axle distance; does not move the outline.")

    def outline(self) -> Outline:
        """Return the boundary of the polygonal parts, the area to the left of it, and the discs."""
        import shapely

        discs = np.array([part.disc() for part in self.parts if part.name == "circle"]).reshape(-1, 3)
        cornered = shapely.union_all([shapely.Polygon(part.corners()) for part in self.parts if part.name != "circle"])
        rounds = [shapely.Point(x, y).buffer(radius, quad_segs=ROUND) for x, y, radius in discs]
        centre = shapely.union_all([cornered, *rounds]).centroid
        corners = tuple(part.corners() for part in self.parts)
        return Outline(segments=_boundary(cornered), discs=discs, centroid=(centre.x, centre.y), parts=corners)


def _boundary(area: Any) -> Floats:
    """Return the rings of a shapely area as segments, outer ones counter-clockwise and holes clockwise."""
    import shapely

    polygons = [shapely.geometry.polygon.orient(polygon) for polygon in shapely.get_parts(area)]
    # The last point of a shapely ring repeats the first one.
    rings = [ring for polygon in polygons for ring in (polygon.exterior, *polygon.interiors) if not polygon.is_empty]
    rows = [chain(shapely.get_coordinates(ring)[:-1], closed=True) for ring in rings]
    return np.concatenate(rows) if rows else np.zeros((0, 4))
