"""Linestring: a thin wall, seen and touched from both sides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from irsim_gym.footprints import random_outline
from irsim_gym.footprints.polygon import regular_vertices
from irsim_gym.footprints.random_outline import draw_outlines, outline_problems
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import Outline, chain
from irsim_gym.world.state import WorldState


@kind
class Linestring:
    """An open chain of segments without area."""

    vertices: tuple[tuple[float, float], ...] | None = option(
        None, min_length=2, unit="m", meaning="Points in the body frame; needed unless random_shape is true."
    )
    random_shape: bool = option(False, meaning="Draw the chain at each reset.")
    is_convex: bool = option(False, meaning="The vertices of a random chain are those of a convex polygon.")
    wheelbase: float | None = option(None, gt=0.0, unit="m", meaning="Axle distance; does not move the chain.")
    number: int = random_outline.NUMBER
    center_range: tuple[float, float, float, float] = random_outline.CENTER_RANGE
    avg_radius_range: tuple[float, float] = random_outline.RADIUS_RANGE
    irregularity_range: tuple[float, float] = random_outline.IRREGULARITY_RANGE
    spikeyness_range: tuple[float, float] = random_outline.SPIKEYNESS_RANGE
    num_vertices_range: tuple[int, int] = random_outline.NUM_VERTICES_RANGE

    @property
    def is_random(self) -> bool:
        """True if the outline differs between levels."""
        return self.random_shape

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from outline_problems(self)
        if self.vertices is not None and len(set(self.vertices)) < 2:
            yield "vertices", "all points are the same"

    def outline(self) -> Outline:
        """Return the segments; a random chain as a regular one with the most vertices it can have."""
        if self.vertices is not None and not self.random_shape:
            return Outline(segments=chain(np.array(self.vertices, np.float64), closed=False), solid=False)
        return Outline(
            segments=chain(self.avg_radius_range[1] * regular_vertices(self.num_vertices_range[1] - 1), closed=True),
            solid=False,
        )

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Draw the members' chains: random outlines without their last side."""
        draw_outlines(
            shard.worlds,
            group.members,
            group.params,
            False,
            model.segment_start,
            state.random,
            model.local_segments,
            model.segment_count,
            model.reach,
        )
