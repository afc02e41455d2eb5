"""manual: poses and goals as given in the file."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind


@kind
class ManualPlacement:
    """Poses and goals as given in the file."""

    is_random: ClassVar[bool] = False
    roams: ClassVar[bool] = False
    ensures_way: ClassVar[bool] = False
    gives_goal: ClassVar[bool] = False

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> str | None:
        """Keep the starts that ``compile`` took from the file."""
        return None

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Put the members on their given starts."""
        put_on_start(shard.worlds, group.members, model, state)


@kernel
def put_on_start(worlds: Ints, members: Ints, model: Model, state: State) -> None:
    """Copy starts to the poses of members that are not placed yet.

    Reads: model (start), state (placed).
    Writes: state (placed, pose).
    """
    for w in worlds:
        for b in members:
            if state.placed[w, b]:
                continue
            for axis in range(3):
                state.pose[w, b, axis] = model.start[w, b, axis]
            state.placed[w, b] = True


def world_box(model: Model, margin: float) -> tuple[Floats, Floats]:
    """Return lower and upper bounds (x, y, heading) of the world, reduced by a margin [m]."""
    x0, y0, x1, y1 = model.bounds
    low = np.array([x0 + margin, y0 + margin, -np.pi])
    high = np.array([x1 - margin, y1 - margin, np.pi])
    return low, high
