"""RVO: the collision-free sampled velocity nearest to the preferred one (van den Berg et al. 2008)."""

from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Records, Vector
from irsim_gym.bodies.behaviors.rvo import velocity_obstacles
from irsim_gym.bodies.behaviors.rvo.free_samples import ROWS, SPAN, RvoTables, nearest_free, rough_cones
from irsim_gym.bodies.behaviors.rvo.penalty import least_penalty
from irsim_gym.bodies.behaviors.shared.map_parts import most_map_discs, most_map_walls
from irsim_gym.bodies.behaviors.shared.steering import Turning, clear_command, to_command, wanted_velocity
from irsim_gym.bodies.behaviors.shared.surroundings import MARGIN, Ego, Surroundings, look_around
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.world.group import Group, Shard, records
from irsim_gym.simulator.world.names import DIFFERENTIAL, Model, State, kernel, kind, option, row_of

TURNING = Turning(0.2, 0.1, 0.02, 1.5)
"""How a differential drive follows the chosen velocity: IR-SIM's constants, whatever its step and its limits are."""


@kind
class Rvo(RenewsGoals):
    """Pick the sampled velocity nearest to the preferred one that leads to no collision."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")
    reads_neighbors: ClassVar[bool] = True

    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="Which other bodies are avoided.")
    vxmax: float = option(1.5, ge=0.0, le=100.0, unit="m/s", meaning="Maximum sampled velocity in x.")
    vymax: float = option(1.5, ge=0.0, le=100.0, unit="m/s", meaning="Maximum sampled velocity in y.")
    acce: float = option(
        1.0,
        gt=0.0,
        unit="m/s",
        meaning="Maximum change of each sampled velocity in a step.",
        consequence="The samples lie 0.05 m/s apart: below 0.025 a single one is left, the lowest.",
    )
    factor: float = option(1.0, ge=0.0, meaning="Weight of the time to collision where every sample collides.")
    mode: Literal["rvo", "hrvo", "vo"] = option("rvo", meaning="How the cone of forbidden velocities is placed.")
    neighbor_threshold: float = option(
        3.0,
        ge=0.0,
        unit="m",
        meaning="Bodies farther away than this are not seen: a moving one or a disc by its centre, a standing one with "
        "sides by its outline. Walls of linestrings are seen from anywhere.",
    )

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate scratch memory for the perception and samples of one body."""
        n_rounds = len(model.role) + model.local_discs.shape[1]
        sight = max(options.neighbor_threshold for options in group.options)
        n_sides, n_discs = model.local_segments.shape[1] + most_map_walls(model, sight), most_map_discs(model, sight)
        n_cones, n_samples = n_rounds + n_discs + n_sides, _most_samples(group.params)
        room = model, n_rounds, n_sides, n_discs
        group.tables = [reserve_tables(Surroundings.reserve(*room), n_cones, n_samples) for _ in range(n_slots)]

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands."""
        decide_rvo(shard.worlds, group.members, group.params, model, state, group.tables[shard.slot])


def _most_samples(params: Any) -> int:
    """Return an upper bound of the number of velocities that any member samples along an axis."""
    # Samples lie between -min(acce, vmax) and min(acce, vmax) about the velocity at most; 3 for both ends and rounding.
    widest = np.minimum(params["acce"], np.maximum(params["vxmax"], params["vymax"])).max()
    return int(2.0 * widest / velocity_obstacles.PITCH) + 3


def free_velocity(options: Rvo, ego: Ego, preferred: Vector, rounds: Records, sides: Floats) -> Vector:
    """Return the velocity that a single body chooses [m/s], outside of any world.

    Args:
        options: Options of the behaviour.
        ego: The body.
        preferred: Velocity towards its goal [m/s].
        rounds: Discs that it sees, records of type ``surroundings.DISC``.
        sides: Walls that it sees: x0, y0, x1, y1 [m], shape ``(n, 4)``.
    """
    none, params = np.zeros(0, np.int64), records([options])
    n_cones, n_samples = len(rounds) + len(sides), _most_samples(params)
    tables = reserve_tables(Surroundings(none, none, rounds, sides, np.zeros((0, 3))), n_cones, n_samples)
    return choose_velocity(ego, preferred, np.inf, params[0], rounds, sides, tables)


def reserve_tables(seen: Surroundings, n_cones: int, n_samples: int) -> RvoTables:
    """Return scratch memory for bodies that see so much, with so many samples along each axis."""
    cones, spans = np.zeros(n_cones, velocity_obstacles.CONE), np.zeros(n_cones, SPAN)
    samples, order = np.zeros((2, n_samples)), np.zeros((2, n_samples), np.int64)
    return RvoTables(seen=seen, cones=cones, spans=spans, rows=np.zeros(1, ROWS), samples=samples, order=order)


@kernel
def decide_rvo(worlds: Ints, members: Ints, params: Any, model: Model, state: State, tables: RvoTables) -> None:
    """Write the commands of bodies that avoid the bodies they see.

    Reads: model (bucket_frame, centroid, disc_count, disc_start, drawn_speed, drive, has_goal, heedless, map_disc,
        map_frame, map_squares, movable, present, radius, reach, role, seen_row, segment_count, segment_start, solid,
        velocity_max, watchers), state (bucket_first, bucket_next, command, discs, goal, pose, segments, twist), tables
        (cones, order, rows, samples, seen).
    Writes: state (command), tables (cones, order, rows, samples, seen, spans).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b, options = members[k], params[k]
            clear_command(state, w, b)
            if not model.has_goal[b] or not model.present[w, b]:
                continue
            roles, sight = options.target_roles, options.neighbor_threshold
            n_rounds, n_sides = look_around(model, state, w, b, roles, sight, tables.seen)
            pose, twist, radius = state.pose[w, b], state.twist[w, b], model.radius[row_of(model.radius, w), b]
            ego = Ego(pose[0], pose[1], twist[0], twist[1], radius + MARGIN)
            preferred = wanted_velocity(model, state, w, b)
            rounds, sides = tables.seen.rounds[:n_rounds], tables.seen.sides[:n_sides]
            most = model.drawn_speed[row_of(model.drawn_speed, w), b]
            vx, vy = choose_velocity(ego, preferred, most, options, rounds, sides, tables)
            command = state.command[w, b]
            to_command(model.drive[b], pose[2], vx, vy, TURNING, command)
            alone, stands = n_rounds == 0 and n_sides == 0, command[0] == 0.0 and command[1] == 0.0
            if model.drive[b] == DIFFERENTIAL and alone and stands:
                # Its goal is behind it, where no sampled velocity leads: it turns on the spot.
                to_command(model.drive[b], pose[2], preferred[0], preferred[1], TURNING, command)
                command[0] = 0.0


@kernel
def choose_velocity(
    ego: Ego, preferred: Vector, most: float, options: Any, rounds: Records, sides: Floats, tables: RvoTables
) -> Vector:
    """Return the best of the sampled velocities [m/s]: outside of all cones, or with the least penalty.

    Along each axis the samples are no faster than ``most`` [m/s].

    Reads: rounds (shape), tables (cones, order, rows, samples, seen).
    Writes: tables (cones, order, rows, samples, seen, spans).
    """
    mode, cones = options.mode, tables.cones
    along_x = velocity_obstacles.lay_samples(ego.vx, options["acce"], min(options.vxmax, most), preferred[0])
    along_y = velocity_obstacles.lay_samples(ego.vy, options["acce"], min(options.vymax, most), preferred[1])
    # Cones of discs come first, with the numbers of their discs; those of walls are appended and always exact.
    n_cones = velocity_obstacles.side_cones(ego, sides, cones, rounds.shape[0])
    rough_cones(mode, ego, rounds, cones)
    best = nearest_free(mode, ego, n_cones, along_x, along_y, tables)
    if best >= 0:
        i, j = best // along_y.n, best % along_y.n
        return along_x.first + i * along_x.step, along_y.first + j * along_y.step
    # Every sample is in a cone: now all cones have to be exact, and `touch_way` of every disc is needed.
    velocity_obstacles.write_samples(along_x, tables.samples[0], tables.order[0])
    velocity_obstacles.write_samples(along_y, tables.samples[1], tables.order[1])
    velocity_obstacles.disc_cones(mode, ego, rounds, cones)
    best = least_penalty(ego, options.factor, rounds, sides, along_x, along_y, tables)
    return tables.samples[0, best // along_y.n], tables.samples[1, best % along_y.n]
