"""slip: wheels that turn more than the robot moves."""

from typing import Annotated, ClassVar

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL
from irsim_gym.simulator.world.names import Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class Slip:
    """The robot moves less than its wheels turn: by (1 - share) of each velocity that its drive executes.

    Its odometry counts the wheels, so it believes in another pose than its own.
    """

    acts_on: ClassVar[str] = "motion"

    ahead: Annotated[Drawn, Bounds(-1.0, 1.0)] = option(0.0, meaning="Share of speeds that is lost; below 0: gained.")
    turn: Annotated[Drawn, Bounds(-1.0, 1.0)] = option(0.0, meaning="Lost share of turn rates or steering angles.")

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Reduce the velocities."""
        let_slip(shard.worlds, group.tables, model, state)


@kernel
def let_slip(worlds: Ints, disturbed: Disturbed, model: Model, state: State) -> None:
    """Reduce what the members execute.

    Reads: disturbed (members, values), model (drive), state (velocity).
    Writes: state (velocity).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            b = disturbed.members[k]
            turns_second = model.drive[b] == DIFFERENTIAL or model.drive[b] == ACKERMANN
            for axis in range(3):
                turns = axis == 2 or (axis == 1 and turns_second)
                state.velocity[w, b, axis] *= 1.0 - disturbed.values[w, k, 1 if turns else 0]
