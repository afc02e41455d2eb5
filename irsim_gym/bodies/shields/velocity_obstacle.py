"""velocity_obstacle: a command that leads to another body is exchanged for one that does not."""

import numpy as np

from irsim_gym.bodies.shields.rolling import begin_rolling, brakes_in_time, roll_on
from irsim_gym.bodies.shields.stop_in_time import slow_down, take_share
from irsim_gym.bodies.shields.tables import ShieldTables, lay_tables
from irsim_gym.bodies.shields.walls import lay_walls
from irsim_gym.simulator.world.names import Group, Ints, Model, Shard, State, kernel, kind, option, row_of
from irsim_gym.simulator.world.response import Response

GRID = 7
"""Values of the first and of the second number of a command that are tried."""
URGENCY = 4.0
"""What a meeting at once costs; to go from one end of a limit to the other costs 1."""


@kind
class VelocityObstacle:
    """Besides what stop_in_time does, a command that leads to a moving body within ``horizon`` is exchanged.

    Bodies count as discs that keep their velocity, as they truly are: a robot needs a tracker. The command whose way is
    free and that differs least takes the place of the learner's; where none is free, a later meeting is better.
    """

    margin: float = option(0.0, ge=0.0, unit="m", meaning="Distance that is kept, where the robot is not nearer yet.")
    horizon: float = option(1.5, gt=0.0, le=60.0, unit="s", meaning="How far ahead others' ways are followed.")

    @staticmethod
    def prepare(group: Group, response: Response, model: Model, n_slots: int) -> None:
        """Make the tables of the members."""
        group.tables = lay_tables(group, response, n_slots)

    @staticmethod
    def shield(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Exchange the members' commands."""
        evade(shard.worlds, shard.slot, group.tables, model, state)
        slow_down(shard.worlds, shard.slot, group.tables, model, state)


@kernel
def evade(worlds: Ints, slot: int, tables: ShieldTables, model: Model, state: State) -> None:
    """Replace each command that leads to a moving body by the best one of a grid after which the body can stop.

    Reads: tables (by_rate, command, horizon, margin, members, need, now, place, response, scan, walls), model
        (acceleration_limit, disc_count, disc_start, drive, local_discs, local_segments, movable, present, reach,
        segment_count, segment_start, solid, speed_bound, step_time, unobstructed, velocity_max, velocity_min,
        wheelbase), state (command, pose, steering, twist, velocity).
    Writes: tables (acted, command, need, now, place, walls), state (command).
    """
    for w in worlds:
        for k in range(tables.members.shape[0]):
            b, tried = tables.members[k], tables.command[slot]
            command, place = state.command[w, b], tables.response.place[b]
            low = model.velocity_min[row_of(model.velocity_min, w), b]
            high = model.velocity_max[row_of(model.velocity_max, w), b]
            take_share(command, 1.0, 1.0, model.drive[b], tried)
            least = URGENCY * (1.0 - meeting(w, k, slot, tables, model, state))
            if least <= 0.0:
                continue
            tried[0], tried[1] = high[0], high[1]
            _, travel = brakes_in_time(w, k, slot, 0, tables, model, state)
            n_walls = lay_walls(w, k, slot, 1.5 * travel, tables, model, state)
            first, second = command[0], command[1]
            for i in range(GRID * GRID):
                tried[0] = low[0] + (high[0] - low[0]) * (i // GRID) / (GRID - 1)
                tried[1] = low[1] + (high[1] - low[1]) * (i % GRID) / (GRID - 1)
                cost = np.abs(tried[0] - first) / max(high[0] - low[0], 1e-9)
                cost += np.abs(tried[1] - second) / max(high[1] - low[1], 1e-9)
                if cost < least and brakes_in_time(w, k, slot, n_walls, tables, model, state)[0]:
                    cost += URGENCY * (1.0 - meeting(w, k, slot, tables, model, state))
                    if cost < least:
                        least, command[0], command[1] = cost, tried[0], tried[1]
                        tables.acted[w, place] = 1


@kernel
def meeting(w: int, k: int, slot: int, tables: ShieldTables, model: Model, state: State) -> float:
    """Return when member k meets a moving body if it holds ``tables.command``, as a share of the horizon; 1 for never.

    Reads: tables (by_rate, command, horizon, margin, members, now, place, response), model (acceleration_limit, drive,
        movable, present, reach, speed_bound, step_time, unobstructed, velocity_max, velocity_min, wheelbase), state
        (pose, steering, twist, velocity).
    Writes: tables (now, place).
    """
    b, at, dt = tables.members[k], tables.place[slot], model.step_time[0]
    pose, reaches = state.pose[w, b], model.reach[row_of(model.reach, w)]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    n = tables.response.n_pending[w, tables.response.place[b]] + int(np.ceil(tables.horizon[k] / dt))
    begin_rolling(w, k, slot, tables, state)
    for step in range(n):
        roll_on(w, k, slot, step, n, tables, model, state)
        x, y, time = pose[0] + cosine * at[0] - sine * at[1], pose[1] + sine * at[0] + cosine * at[1], (step + 1) * dt
        for q in range(model.movable.shape[0]):
            if q == b or not model.movable[q] or not model.present[w, q] or model.unobstructed[q]:
                continue
            dx, dy = state.pose[w, q, 0] - pose[0], state.pose[w, q, 1] - pose[1]
            need = min(reaches[b] + reaches[q] + tables.margin[k], np.sqrt(dx * dx + dy * dy))
            dx = state.pose[w, q, 0] + time * state.twist[w, q, 0] - x
            dy = state.pose[w, q, 1] + time * state.twist[w, q, 1] - y
            if dx * dx + dy * dy < need * need:
                return float(step / n)
    return 1.0
