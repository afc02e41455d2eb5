"""lost_commands: commands that do not reach the drive."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, option, uniform


@kind
class LostCommands:
    """Some commands do not reach the drive, which goes on with the last one that did; at the start it stands still."""

    acts_on: ClassVar[str] = "command"

    chance: Annotated[Drawn, Bounds(0.0, 1.0)] = option(0.0, meaning="Probability, in each step, that it is lost.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for the command that the drive has got last."""
        group.arrays["held"] = np.zeros((*group.tables.count.shape, 3))

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Replace commands that are lost."""
        lose_commands(shard.worlds, group.tables, group.arrays["held"], state)


@kernel
def lose_commands(worlds: Ints, disturbed: Disturbed, held: Floats, state: State) -> None:
    """Hold the last command in steps in which the new one is lost.

    Reads: disturbed (count, members, random, values), state (command).
    Writes: disturbed (count, random), held, state (command).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            command = state.command[w, disturbed.members[k]]
            is_lost = uniform(disturbed.random[w], k, 0.0, 1.0) < disturbed.values[w, k, 0]
            for axis in range(3):
                if disturbed.count[w, k] == 0:
                    held[w, k, axis] = 0.0
                if not is_lost:
                    held[w, k, axis] = command[axis]
                command[axis] = held[w, k, axis]
            disturbed.count[w, k] += 1
