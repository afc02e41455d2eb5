"""The task of a local planner at one moment: its goal, path and obstacles."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Flags, Floats, Records, Vector
from irsim_gym.bodies.behaviors.local_planners.rollouts import POSES, find_nearest, gap_at, lay_poses
from irsim_gym.bodies.behaviors.local_planners.way import MOST_POINTS, LocalWays, lay_way, way_length
from irsim_gym.bodies.behaviors.pursuit.motion import Moving, moving_of
from irsim_gym.bodies.behaviors.shared.steering import commanded_by_rate
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, Group, Model, State, Struct, kernel, row_of
from irsim_gym.simulator.world.outline import own_outline
from irsim_gym.simulator.world.own_scan import OwnScan, find_hits

LETHAL = 253.0
"""Cost of touching the padded footprint, as in ROS's cost maps."""
CLOSE = 1e-9
"""Tolerance for rounding."""


@dataclass(repr=False)
class LocalTables(Struct):
    """The tables of what bodies see and follow, with scratch memory of one shard.

    Attributes:
        by_rate: Flags of steered bodies that are commanded by a turn rate, shape ``(n_bodies,)``.
        hits: Scratch: x and y of the scan's hits [m], shape ``(2, n_beams)``.
        poses: Scratch: a record of type ``POSES``, shape ``(1,)``.
        way: Scratch: x and y of the path ahead [m], shape ``(2, MOST_POINTS + 1)``.
        ways: The paths.
    """

    by_rate: Flags
    hits: Floats
    poses: Records
    way: Floats
    ways: LocalWays

    @classmethod
    def reserve(cls, group: Group, model: Model, n_slots: int) -> list[Self]:
        """Return memory for each slot."""
        by_rate, n_beams = np.zeros(len(model.role), np.bool_), group.scan.ranges.shape[2]
        by_rate[group.members] = commanded_by_rate(group)
        return [
            cls(by_rate, np.zeros((2, n_beams)), np.zeros(1, POSES), np.zeros((2, MOST_POINTS + 1)), ways)
            for ways in LocalWays.reserve(group, model, n_slots)
        ]


class LocalTask(NamedTuple):
    """The task of a body, in its own frame.

    Attributes:
        moving: What it does and can do.
        facing: Cosine and sine of its heading.
        outline: Its outline.
        reach: Radius of the disc that encloses it [m].
        n_hits: Number of points that it sees, in ``LocalTables.hits``.
        bearable: Distance below which a motion counts as touching [m]: the padding, or less if the body is closer now.
        n_way: Number of points of the path, in ``LocalTables.way``.
        length: Length of the path [m].
        goal_x: x of the goal [m].
        goal_y: y of the goal [m].
        goal_radius: Distance from the goal below which it has arrived [m].
        forward: Distance ahead of the body at which the end of a motion is measured [m].
    """

    moving: Moving
    facing: Vector
    outline: BodyOutline
    reach: float
    n_hits: int
    bearable: float
    n_way: int
    length: float
    goal_x: float
    goal_y: float
    goal_radius: float
    forward: float


@kernel
def is_under_way(model: Model, state: State, w: int, b: int) -> bool:
    """Return whether a body is there and has a goal that it has not reached.

    Reads: model (goal_threshold, has_goal, present), state (goal, pose).
    """
    if not model.has_goal[b] or not model.present[w, b]:
        return False
    dx, dy = state.goal[w, b, 0] - state.pose[w, b, 0], state.goal[w, b, 1] - state.pose[w, b, 1]
    return bool(np.sqrt(dx * dx + dy * dy) >= model.goal_threshold[row_of(model.goal_threshold, w), b])


@kernel
def task_of(w: int, b: int, n_hits: int, options: Any, model: Model, state: State, tables: LocalTables) -> LocalTask:
    """Return what body b of world w has to do; ``tables.way`` is written.

    Reads: model (acceleration_limit, disc_count, disc_start, drive, goal_threshold, local_discs, local_segments, reach,
        segment_count, segment_start, solid, step_time, velocity_max, velocity_min, wheelbase), state (goal, pose,
        steering, twist, velocity), tables (by_rate, hits, poses, way, ways).
    Writes: tables (poses, way).
    """
    moving, outline = moving_of(model, state, w, b, tables.by_rate[b]), own_outline(model, w, b)
    cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
    dx, dy = state.goal[w, b, 0] - state.pose[w, b, 0], state.goal[w, b, 1] - state.pose[w, b, 1]
    reach, near = model.reach[row_of(model.reach, w), b], model.goal_threshold[row_of(model.goal_threshold, w), b]
    n_way = lay_way(state, tables.ways, w, b, options.lookahead, tables.way)
    rolls = moving.drive in (DIFFERENTIAL, ACKERMANN)
    bearable = bearable_gap(outline, reach, n_hits, options.footprint_padding, tables)
    # Into the body's frame, in which hits, path and rollouts are.
    goal_x, goal_y = cosine * dx + sine * dy, cosine * dy - sine * dx
    forward = min(options.forward_point, np.sqrt(dx * dx + dy * dy)) if rolls else 0.0
    length = way_length(tables.way, n_way)
    facing = cosine, sine
    return LocalTask(moving, facing, outline, reach, n_hits, bearable, n_way, length, goal_x, goal_y, near, forward)


@kernel
def see_hits(scan: OwnScan, w: int, k: int, options: Any, hits: Floats) -> int:
    """Write what member k sees, in the body frame [m]; return the number of points.

    A point that is nearer than ``options.spacing`` to the one of the beam before it is left out.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: hits.
    """
    count, spacing2 = 0, options.spacing * options.spacing
    for j in range(find_hits(scan, w, k, options.obstacle_range, hits)):
        x, y = hits[0, j], hits[1, j]
        if count > 0:
            dx, dy = x - hits[0, count - 1], y - hits[1, count - 1]
            if dx * dx + dy * dy < spacing2:
                continue
        hits[0, count], hits[1, count] = x, y
        count += 1
    return count


@kernel
def bearable_gap(outline: BodyOutline, reach: float, n_hits: int, padding: float, tables: LocalTables) -> float:
    """Return the distance below which a way counts as touching [m]: the padding, or less if the body is nearer now.

    A body that touches something already may go anywhere.

    Reads: tables (hits, poses).
    Writes: tables (poses).
    """
    poses = tables.poses[0]
    # A twist and a time of 0 leave every lane at the body's present pose.
    lay_poses((0.0, 0.0, 0.0), 0, 0.0, poses)
    find_nearest(tables.hits, n_hits, poses)
    gap = gap_at(outline, reach, padding + CLOSE, tables.hits, n_hits, poses, 0)
    # -CLOSE: no distance is below it, so that nothing counts as touched.
    return max(min(gap, padding) - CLOSE, CLOSE) if gap > 0.0 else -CLOSE


@kernel
def obstacle_cost(options: Any, gap: float) -> float:
    """Return the cost of a distance [m] from the nearest obstacle: LETHAL at the padding, and falling with it."""
    beyond = gap - options.footprint_padding
    if beyond >= options.inflation_radius:
        return 0.0
    return float(LETHAL * np.exp(-options.cost_scaling * max(beyond, 0.0)))
