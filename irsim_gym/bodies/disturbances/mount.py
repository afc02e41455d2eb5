"""mount: sensors that stand elsewhere than their entry says."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn, drawn_problems
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class Mount:
    """The robot's sensors are mounted elsewhere than their ``offset`` says, all of them as one piece.

    They turn about the place of the first range sensor.
    """

    acts_on: ClassVar[str] = "sight"

    x: Annotated[Drawn, Bounds(-100.0, 100.0)] = option(0.0, unit="m", meaning="How far they are ahead of it.")
    y: Annotated[Drawn, Bounds(-100.0, 100.0)] = option(0.0, unit="m", meaning="How far they are to the left of it.")
    turn: Annotated[Drawn, Bounds(-10.0, 10.0)] = option(
        0.0, unit="rad", meaning="How far they are turned to the left."
    )

    problems = drawn_problems

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Move the poses from which the sensors look."""
        move_eyes(shard.worlds, group.tables, group.arrays["offset"], state)


@kernel
def move_eyes(worlds: Ints, disturbed: Disturbed, offset: Floats, state: State) -> None:
    """Write the pose that a body would have, were its sensors where its entry says.

    Reads: disturbed (members, values), state (direction, pose).
    Writes: state (direction, pose).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            pose, known = state.pose[w, disturbed.members[k]], state.direction[w, disturbed.members[k]]
            x, y = offset[k, 0] + disturbed.values[w, k, 0], offset[k, 1] + disturbed.values[w, k, 1]
            cosine, sine = np.cos(pose[2]), np.sin(pose[2])
            pose[0], pose[1] = pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y
            pose[2] += disturbed.values[w, k, 2]
            known[0], known[1], known[2] = np.cos(pose[2]), np.sin(pose[2]), pose[2]
            pose[0] -= known[0] * offset[k, 0] - known[1] * offset[k, 1]
            pose[1] -= known[1] * offset[k, 0] + known[0] * offset[k, 1]
