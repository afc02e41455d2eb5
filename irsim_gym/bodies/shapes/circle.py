"""Circle: an exact disc."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.base.options import kind, option, unordered_ranges
from irsim_gym.simulator.world.names import Group, Ints, Model, Outline, Shard, State, kernel, uniform

LEAST_SIZE = 1e-3
"""Lower bound of random radii [m]."""


@kind
class Circle:
    """A disc."""

    keeps_symmetry: ClassVar[bool] = True

    radius: float = option(0.2, gt=0.0, unit="m", meaning="Radius.")
    center: tuple[float, float] = option((0.0, 0.0), unit="m", meaning="Centre in the body frame.")
    random_shape: bool = option(False, meaning="Draw the radius from radius_range at each reset.")
    radius_range: tuple[float, float] = option((0.1, 1.0), unit="m", meaning="Bounds of a random radius.")
    wheelbase: float | None = option(None, ge=0.0, unit="m", meaning="Axle distance; half of it shifts the disc ahead.")

    @property
    def is_random(self) -> bool:
        """True if the outline differs between levels."""
        return self.random_shape

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from unordered_ranges(self, "radius_range", least=LEAST_SIZE)

    def outline(self) -> Outline:
        """Return the disc; a random one at its largest."""
        radius = self.radius_range[1] if self.random_shape else self.radius
        ahead = 0.0 if self.wheelbase is None else self.wheelbase / 2.0
        return Outline(discs=np.array([[self.center[0] + ahead, self.center[1], radius]]))

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Draw the members' radii."""
        draw_discs(shard.worlds, group.members, group.params, model, state)


@kernel
def draw_discs(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write a radius between the bounds of ``radius_range`` and the reach that follows from it.

    Reads: model (disc_start, local_discs), state (random).
    Writes: model (local_discs, reach), state (random).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            # Random outlines have rows of their own in each world, so that w is the row.
            disc = model.local_discs[w, model.disc_start[members[k]]]
            disc[2] = uniform(state.random, w, params[k].radius_range[0], params[k].radius_range[1])
            model.reach[w, members[k]] = np.sqrt(disc[0] * disc[0] + disc[1] * disc[1]) + disc[2]
