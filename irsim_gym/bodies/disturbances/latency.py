"""latency: commands act later."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed, whole_steps
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.simulator.world.response import Response


@kind
class Latency:
    """A command reaches the drive this time after the measurement that it answers; until then the drive stands still.

    How much of it passes before the learner sees the measurement, and how much after its command, makes no difference:
    what it sees and does is the same, so all of it stands between command and drive.
    """

    acts_on: ClassVar[str] = "command"

    time: Annotated[Drawn, Bounds(0.0, 10.0)] = option(0.0, unit="s", meaning="Time from measuring to wheels.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for the commands under way, and for how many steps they are."""
        most = whole_steps(float(group.tables.high.max()), float(model.step_time[0]))
        group.arrays["queue"] = np.zeros((*group.tables.count.shape, most + 1, 3))
        group.arrays["steps"] = np.zeros(group.tables.count.shape, np.int64)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Queue the commands, and take those that are due."""
        delay_commands(shard.worlds, group.tables, group.arrays["queue"], group.arrays["steps"], model, state)

    @staticmethod
    def foresee(group: Group, model: Model, response: Response, shard: Shard) -> None:
        """Write the commands under way."""
        list_pending(shard.worlds, group.tables, group.arrays["queue"], model, response)


@kernel
def delay_commands(worlds: Ints, disturbed: Disturbed, queue: Floats, steps: Ints, model: Model, state: State) -> None:
    """Replace each command by the one that is due, zeros before the first one is.

    Reads: disturbed (count, members, values), model (step_time), state (command).
    Writes: disturbed (count), queue, steps, state (command).
    """
    size = queue.shape[2]
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            command, n, row = state.command[w, disturbed.members[k]], disturbed.count[w, k], queue[w, k]
            if n == 0:
                steps[w, k] = whole_steps(disturbed.values[w, k, 0], model.step_time[0])
            place = n % size
            due = place - steps[w, k]
            due = due + size if due < 0 else due
            for axis in range(3):
                row[place, axis] = command[axis]
                command[axis] = row[due, axis] if n >= steps[w, k] else 0.0
            disturbed.count[w, k] = n + 1


@kernel
def list_pending(worlds: Ints, disturbed: Disturbed, queue: Floats, model: Model, response: Response) -> None:
    """Write the commands of a queue, zeros before the first one, ahead of those that reach it later.

    Reads: disturbed (count, members, values), model (step_time), response (n_pending, pending, place).
    Writes: response (n_pending, pending).
    """
    size = queue.shape[2]
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            place = response.place[disturbed.members[k]]
            if place < 0:
                continue
            steps = whole_steps(disturbed.values[w, k, 0], model.step_time[0])
            first, count, rows = disturbed.count[w, k] - steps, response.n_pending[w, place], response.pending[w, place]
            for axis in range(3):
                for i in range(count - 1, -1, -1):
                    rows[steps + i, axis] = rows[i, axis]
                for i in range(steps):
                    rows[i, axis] = queue[w, k, (first + i) % size, axis] if first + i >= 0 else 0.0
            response.n_pending[w, place] = count + steps
