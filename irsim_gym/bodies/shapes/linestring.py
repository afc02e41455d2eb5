"""Linestring: a thin wall, seen and touched from both sides."""

from collections.abc import Iterator

from irsim_gym.bodies.shapes.random_outline import VertexShape, draw_outlines, outline_problems
from irsim_gym.simulator.world.names import Group, Model, Outline, Shard, State, chain, kind


@kind
class Linestring(VertexShape):
    """An open chain of segments without area."""

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from outline_problems(self)
        if self.vertices is not None and len(set(self.vertices)) < 2:
            yield "vertices", "all points are the same"

    def outline(self) -> Outline:
        """Return the segments; a random chain as a regular one with the most vertices it can have."""
        points = self.given()
        return Outline(segments=self.largest() if points is None else chain(points, closed=False), solid=False)

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Draw the members' chains: random outlines without their last side."""
        draw_outlines(shard.worlds, group.members, group.params, False, model, state)
