"""Rectangle: length along the body's x axis, width along its y axis."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.base.options import kind, option, unordered_ranges
from irsim_gym.simulator.world.names import Group, Ints, Model, Outline, Shard, State, chain, kernel, uniform

LEAST_SIZE = 1e-3
"""Lower bound of random lengths and widths [m]."""


@kind
class Rectangle:
    """A rectangle about the body's origin; with a wheelbase the origin is the rear axle."""

    keeps_symmetry: ClassVar[bool] = True

    length: float = option(1.0, gt=0.0, unit="m", meaning="Size along the body's x axis.")
    width: float = option(1.0, gt=0.0, unit="m", meaning="Size along the body's y axis.")
    wheelbase: float | None = option(None, ge=0.0, unit="m", meaning="Axle distance; the origin is on the rear axle.")
    random_shape: bool = option(False, meaning="Draw length and width at each reset.")
    length_range: tuple[float, float] = option((0.1, 1.0), unit="m", meaning="Bounds of a random length.")
    width_range: tuple[float, float] = option((0.1, 1.0), unit="m", meaning="Bounds of a random width.")

    @property
    def is_random(self) -> bool:
        """True if the outline differs between levels."""
        return self.random_shape

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from unordered_ranges(self, "length_range", "width_range", least=LEAST_SIZE)

    def outline(self) -> Outline:
        """Return the four sides, counter-clockwise; a random rectangle at its largest."""
        length = self.length_range[1] if self.random_shape else self.length
        width = self.width_range[1] if self.random_shape else self.width
        ahead = 0.0 if self.wheelbase is None else self.wheelbase / 2.0
        right, top = length / 2.0, width / 2.0
        corners = np.array([[-right, -top], [right, -top], [right, top], [-right, top]])
        return Outline(segments=chain(corners + np.array([ahead, 0.0]), closed=True))

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Draw the members' lengths and widths."""
        draw_rectangles(shard.worlds, group.members, group.params, model, state)


@kernel
def draw_rectangles(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write the sides of rectangles with random length and width, and the reach that follows.

    Reads: model (segment_start), state (random).
    Writes: model (local_segments, reach), state (random).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            bounds = params[k]
            right = 0.5 * uniform(state.random, w, bounds.length_range[0], bounds.length_range[1])
            top = 0.5 * uniform(state.random, w, bounds.width_range[0], bounds.width_range[1])
            # With a wheelbase, the origin is on the rear axle, half of it behind the middle. NaN stands for None.
            ahead = 0.0 if np.isnan(bounds.wheelbase) else 0.5 * bounds.wheelbase
            sides = model.local_segments[w, model.segment_start[members[k]] : model.segment_start[members[k]] + 4]
            # Counter-clockwise from the lower left: below, right, above, left.
            for side in range(4):
                x0 = right if side == 1 or side == 2 else -right
                y0 = top if side >= 2 else -top
                x1 = right if side <= 1 else -right
                y1 = top if side == 1 or side == 2 else -top
                sides[side, 0], sides[side, 1], sides[side, 2], sides[side, 3] = x0 + ahead, y0, x1 + ahead, y1
            # The front corners are the farthest, as `ahead` is not negative.
            model.reach[w, members[k]] = np.sqrt((right + ahead) * (right + ahead) + top * top)
