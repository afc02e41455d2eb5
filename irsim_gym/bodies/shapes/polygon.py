"""Polygon: given vertices, or a random outline."""

from collections.abc import Iterator

import numpy as np

from irsim_gym.bodies.shapes.random_outline import VertexShape, draw_outlines, outline_problems
from irsim_gym.simulator.geometry.polygons import signed_area
from irsim_gym.simulator.world.names import Group, Model, Outline, Shard, State, chain, kind


@kind
class Polygon(VertexShape):
    """A simple polygon, convex or not."""

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from outline_problems(self)
        if self.vertices is not None and not self.random_shape and (flaw := flaw_of(self.vertices)):
            yield "vertices", flaw

    def outline(self) -> Outline:
        """Return the sides, counter-clockwise; a random polygon as a regular one with the most vertices it can have."""
        corners = self.given()
        if corners is None:
            return Outline(segments=self.largest())
        return Outline(segments=chain(corners if signed_area(corners) > 0.0 else corners[::-1], closed=True))

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Draw the members' outlines."""
        draw_outlines(shard.worlds, group.members, group.params, True, model, state)


def flaw_of(vertices: tuple[tuple[float, float], ...]) -> str:
    """Return why these corners bound no area: too few, all on a line, or sides that cross; empty when they do."""
    import shapely
    from shapely.validation import explain_validity

    if len(set(vertices)) < 3:
        return "a polygon needs three different corners"
    with np.errstate(all="ignore"):
        outline = shapely.Polygon(vertices)
        if outline.is_valid and outline.area > 0.0:
            return ""
        return f"the outline crosses or touches itself ({explain_validity(outline).lower()})"
