"""Polygon: given vertices, or a random outline."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from irsim_gym.footprints import random_outline
from irsim_gym.footprints.random_outline import draw_outlines, outline_problems
from irsim_gym.geometry.polygons import signed_area
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import Outline, chain
from irsim_gym.world.state import WorldState


@kind
class Polygon:
    """A simple polygon, convex or not."""

    vertices: tuple[tuple[float, float], ...] | None = option(
        None, min_length=3, unit="m", meaning="Corners in the body frame; needed unless random_shape is true."
    )
    random_shape: bool = option(False, meaning="Draw the outline at each reset.")
    is_convex: bool = option(False, meaning="A random outline is convex (the hull of what is drawn).")
    wheelbase: float | None = option(None, gt=0.0, unit="m", meaning="Axle distance; does not move the outline.")
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
        if self.vertices is not None and not self.random_shape and (flaw := flaw_of(self.vertices)):
            yield "vertices", flaw

    def outline(self) -> Outline:
        """Return the sides, counter-clockwise; a random polygon as a regular one with the most vertices it can have."""
        if self.vertices is not None and not self.random_shape:
            corners = np.array(self.vertices, np.float64)
            return Outline(segments=chain(corners if signed_area(corners) > 0.0 else corners[::-1], closed=True))
        return Outline(
            segments=chain(self.avg_radius_range[1] * regular_vertices(self.num_vertices_range[1] - 1), closed=True)
        )

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Draw the members' outlines."""
        draw_outlines(
            shard.worlds,
            group.members,
            group.params,
            True,
            model.segment_start,
            state.random,
            model.local_segments,
            model.segment_count,
            model.reach,
        )


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


def regular_vertices(count: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return the corners of a regular polygon on the unit circle [m], shape ``(count, 2)``."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)
