"""Recorded: replay the path of a recorded person."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from irsim_gym.bodies.behaviors.shared.steering import Turning, to_command
from irsim_gym.scenario.specs.recordings import sampled
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, Struct, kernel, kind, option

STRAIGHT = Turning(1.0, 0.0, 0.0, 0.0)
"""For drives that do not turn."""


@kind
class Recorded:
    """Replay the path of a recorded person; the body is present only while the person is.

    Between the rows of the file it walks in straight lines, in each step to the person's next position. If it is
    stopped, it falls behind.
    """

    kinematics: ClassVar[tuple[str, ...]] = ("omni",)
    reads_neighbors: ClassVar[bool] = False
    replays: ClassVar[bool] = True

    file: str = option(min_length=1, meaning="Text file of rows time, id, x, y as of ETH and UCY, shipped or beside.")
    time_unit: float = option(1.0, gt=0.0, unit="s", meaning="Unit of the first column, e.g. 0.04 for frames at 25 Hz.")
    person: int | None = option(None, meaning="Id of the person; default: the bodies are those of the file in order.")
    start_time: float = option(0.0, ge=0.0, unit="s", meaning="Time after the file's first row when episodes begin.")
    offset: tuple[float, float] = option((0.0, 0.0), unit="m", meaning="Added to all positions.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Compute the position of each person at each step."""
        ways = [sampled(options, float(model.step_time[0])) for options in group.options]
        # One row more than the longest way: NaN, so that everybody is absent after the last step.
        points = np.full((len(ways), max(map(len, ways)) + 1, 2), np.nan)
        for row, way in zip(points, ways, strict=True):
            row[: len(way)] = way
        group.tables = RecordedTables(points)

    @staticmethod
    def appear(group: Group, model: Model, state: State, shard: Shard, ahead: int) -> None:
        """Make members present or absent as their recorded persons come and go."""
        come_and_go(shard.worlds, group.members, ahead, model, state, group.tables)

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands."""
        decide_recorded(shard.worlds, group.members, group.params, model, state, group.tables)


@dataclass
class RecordedTables(Struct):
    """The positions of persons.

    Attributes:
        points: Positions at each step [m], NaN while they are absent, shape ``(n_members, n_steps, 2)``.
    """

    points: Floats


@kernel
def come_and_go(worlds: Ints, members: Ints, ahead: int, model: Model, state: State, tables: RecordedTables) -> None:
    """Write who is there ``ahead`` steps from now; who comes stands where its person is.

    Reads: model (present), state (step), tables (points).
    Writes: model (present), state (collided, hit, pose, stopped, twist, velocity).
    """
    for w in worlds:
        # The last row holds from then on.
        step = min(state.step[w] + ahead, tables.points.shape[1] - 1)
        for k in range(members.shape[0]):
            b, x, y = members[k], tables.points[k, step, 0], tables.points[k, step, 1]
            if np.isnan(x):
                model.present[w, b] = False
            # Bodies are put in place when they come, or at the start; then they walk, see decide_recorded.
            elif not model.present[w, b] or step == 0:
                model.present[w, b] = True
                state.pose[w, b, 0], state.pose[w, b, 1] = x, y
                state.collided[w, b], state.stopped[w, b], state.hit[w, b] = False, False, -1
                for axis in range(3):
                    state.velocity[w, b, axis], state.twist[w, b, axis] = 0.0, 0.0


@kernel
def decide_recorded(
    worlds: Ints, members: Ints, params: Any, model: Model, state: State, tables: RecordedTables
) -> None:
    """Write the commands that lead to where the persons are after the step.

    Reads: model (drive, step_time), state (pose, step), tables (points).
    Writes: state (command).
    """
    dt = model.step_time[0]
    for w in worlds:
        following = min(state.step[w] + 1, tables.points.shape[1] - 1)
        for k in range(members.shape[0]):
            # Only some members may decide in a turn: their rows are those that they have in the whole group.
            b, m = members[k], params[k].index
            x, y = tables.points[m, following, 0], tables.points[m, following, 1]
            vx, vy = 0.0, 0.0
            if not np.isnan(x):
                vx, vy = (x - state.pose[w, b, 0]) / dt, (y - state.pose[w, b, 1]) / dt
            to_command(model.drive[b], state.pose[w, b, 2], vx, vy, STRAIGHT, state.command[w, b])
