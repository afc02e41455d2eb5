"""stop_in_time: a command is slowed down until the robot can stop before what its scan shows."""

import numpy as np

from irsim_gym.bodies.shields.rolling import brakes_in_time
from irsim_gym.bodies.shields.tables import ShieldTables, lay_tables
from irsim_gym.bodies.shields.walls import ROUNDING, lay_walls
from irsim_gym.simulator.geometry.angles import wrap
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.simulator.world.response import Response
from irsim_gym.simulator.world.twist import body_twist

HALVINGS = 7
"""Halvings of the interval in which the greatest speed lies."""


@kind
class StopInTime:
    """A command is passed on if the robot can stop after it before what its scan shows, else it is slowed down.

    How far the robot goes until it stands follows from what is known of it: the commands under way in ``latency``, the
    time constant of ``drive_lag``, the limits of speed and acceleration. A robot that may turn on the spot keeps its
    turn rate, others keep their arc. It does not drive in directions in which its sensor does not look.
    """

    margin: float = option(0.0, ge=0.0, unit="m", meaning="Distance that is kept, where the robot is not nearer yet.")

    @staticmethod
    def prepare(group: Group, response: Response, model: Model, n_slots: int) -> None:
        """Make the tables of the members."""
        group.tables = lay_tables(group, response, n_slots)

    @staticmethod
    def shield(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Slow down the members' commands."""
        slow_down(shard.worlds, shard.slot, group.tables, model, state)


@kernel
def slow_down(worlds: Ints, slot: int, tables: ShieldTables, model: Model, state: State) -> None:
    """Replace each command after which the body cannot stop in time by the fastest one of its sort after which it can.

    If there is none, it is a full stop, for which the command before has left room.

    Reads: tables (acted, by_rate, command, margin, members, need, now, place, response, scan, walls), model
        (acceleration_limit, disc_count, disc_start, drive, local_discs, local_segments, reach, segment_count,
        segment_start, solid, speed_bound, step_time, velocity_max, velocity_min, wheelbase), state (command, pose,
        steering, velocity).
    Writes: tables (acted, command, need, now, place, walls), state (command).
    """
    for w in worlds:
        for k in range(tables.members.shape[0]):
            b = tables.members[k]
            place, command, tried = tables.response.place[b], state.command[w, b], tables.command[slot]
            is_seen = looks_there(w, k, tables, model, state)
            take_share(command, 1.0, 1.0, model.drive[b], tried)
            _, travel = brakes_in_time(w, k, slot, 0, tables, model, state)
            n_walls = lay_walls(w, k, slot, travel, tables, model, state)
            if is_seen and brakes_in_time(w, k, slot, n_walls, tables, model, state)[0]:
                continue
            take_share(command, 0.0, 1.0, model.drive[b], tried)
            turns = model.drive[b] != ACKERMANN and brakes_in_time(w, k, slot, n_walls, tables, model, state)[0]
            # A car's steering angle is its arc, a turn rate has to become smaller with the speed.
            keeps = turns or (model.drive[b] == ACKERMANN and not tables.by_rate[k])
            low, high = 0.0, 1.0
            for _ in range(HALVINGS if is_seen else 0):
                share = 0.5 * (low + high)
                take_share(command, share, 1.0 if keeps else share, model.drive[b], tried)
                stops = brakes_in_time(w, k, slot, n_walls, tables, model, state)[0]
                low, high = share if stops else low, high if stops else share
            take_share(command, low, 1.0 if turns or (keeps and low > 0.0) else low, model.drive[b], tried)
            for axis in range(3):
                tables.acted[w, place] |= command[axis] != tried[axis]
                command[axis] = tried[axis]


@kernel
def take_share(command: Floats, share: float, turn_share: float, drive: int, tried: Floats) -> None:
    """Write a share of a command's speed, and a share of its turn rate or steering angle.

    Writes: tried.
    """
    turn = 2 if drive == OMNI_ANGULAR else 1 if drive in (DIFFERENTIAL, ACKERMANN) else 3
    for axis in range(3):
        tried[axis] = command[axis] * (turn_share if axis == turn else share)


@kernel
def looks_there(w: int, k: int, tables: ShieldTables, model: Model, state: State) -> bool:
    """Return whether member k's command drives in a direction in which its sensor looks, or nowhere.

    Reads: tables (members, scan), model (drive), state (command, pose).
    """
    b, angles = tables.members[k], tables.scan.angles[tables.scan.sensors[k]]
    cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
    ahead, left, _ = body_twist(state.command[w, b], 0.0, cosine, sine, model.drive[b], 1.0)
    half, middle = 0.5 * (angles[-1] - angles[0]), 0.5 * (angles[-1] + angles[0])
    if ahead == 0.0 and left == 0.0:
        return True
    return bool(np.abs(wrap(np.arctan2(left, ahead) - middle)) <= half + ROUNDING)
