"""Hybrid A* (Dolgov, Thrun, Montemerlo, Diebel 2008): a path over poses on which a body's outline touches nothing.

The search runs over cells of position and heading, and keeps the pose that it reached in each cell. The heuristic is
the higher cost of two paths: that of a point around the obstacles, and that of the body without obstacles. Moves are
tested only when their poses are next in the queue.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Pose, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.hybrid_astar import queue
from irsim_gym.bodies.behaviors.hybrid_astar.costs import Aim, aim_gap, cost_without_obstacles, seconds_of
from irsim_gym.bodies.behaviors.hybrid_astar.last import lay_last
from irsim_gym.bodies.behaviors.hybrid_astar.moves import N_HEADINGS, pose_after
from irsim_gym.simulator.cell_paths.outline_room import PoseShape, room_at_pose
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.paths.geodesic import field_at
from irsim_gym.simulator.paths.grid import Grid

NEAR = 2.0
"""Extra cost of time spent at an obstacle, as a multiple of the time; it falls to 0 at the distance ``clearance``."""
GREED = 1.3
"""Weight of the estimated remaining cost (weighted A*): paths cost little more than the least, and are found sooner."""
LAST_CELLS = 6.0
"""Maximum distance from which a move may lead straight to the goal [cells]."""
LEAST_STEP = 1e-3
"""Minimum distance between tested poses along a move [m]."""


class PoseTask(NamedTuple):
    """The task of a search.

    Attributes:
        obstacles: The obstacles.
        shape: The body's outline.
        padding: Minimum distance from obstacles [m].
        aim: The goal.
        moves: The body's moves, shape ``(n_moves,)``.
        last: Scratch: the move straight to the goal.
        fastest: The body's maximum speed [m/s].
        cell: Cell size of the search [m].
        costs: Costs of paths to the goal without obstacles, see ``pose_costs``.
        costs_cell: Cell size of ``costs`` [m].
        beyond: Cost of poses from which no way stays within the table of ``costs`` [s]; inf to leave such poses out.
        grid: The grid of ``field``.
        field: Distance of a disc within the body from the goal [m].
        options: Those of ``HybridAstar``.
    """

    obstacles: Obstacles
    shape: PoseShape
    padding: float
    aim: Aim
    moves: Records
    last: Record
    fastest: float
    cell: float
    costs: Floats
    costs_cell: float
    beyond: float
    grid: Grid
    field: Floats
    options: Record


@kernel
def cost_to_go(task: PoseTask, pose: Pose) -> float:
    """Return what the way from a pose to the goal costs at least, but for how coarse cells are [s].

    It is at least ``beyond`` where no way stays within the table of costs without obstacles.
    """
    # Where the field knows no way, as in cells beside obstacles, the straight line is a lower bound.
    far = field_at(task.field, task.grid, pose[0], pose[1])
    if not far < np.inf:
        dx, dy = pose[0] - task.aim.x, pose[1] - task.aim.y
        far = np.sqrt(dx * dx + dy * dy)
    # The goal is an area: arriving at its edge is enough.
    around = max(far - task.aim.radius, 0.0) / task.fastest
    alone = cost_without_obstacles(task.aim, task.costs, task.costs_cell, pose)
    return max(around, alone if alone < np.inf else task.beyond)


@kernel
def cell_of(task: PoseTask, pose: Pose) -> int:
    """Return the number of the cell that holds a pose; -1 outside of the world."""
    grid = task.grid
    across, up = (pose[0] - grid.origin_x) / task.cell, (pose[1] - grid.origin_y) / task.cell
    # The search's own cells over the same rectangle; one more where they do not divide it.
    columns = int(grid.columns * grid.cell / task.cell) + 1
    rows = int(grid.rows * grid.cell / task.cell) + 1
    if not (0.0 <= across < columns and 0.0 <= up < rows):
        return -1
    turns = pose[2] / (2.0 * np.pi)
    heading = int((turns - np.floor(turns)) * N_HEADINGS + 0.5) % N_HEADINGS
    return (int(up) * columns + int(across)) * N_HEADINGS + heading


@kernel
def room_along(task: PoseTask, pose: Pose, room: float, move: Record) -> tuple[float, float]:
    """Return the least distance of the body from what is in the way on a move, and that at its end [m].

    Both are 0 if the move comes nearer than the padding.

    From a pose at a distance d, no point of the body touches anything on less than d of its way. So poses are looked at
    that far apart, less the padding; nothing comes nearer than half of it in between.

    Args:
        task: The search.
        pose: Where the move begins.
        room: The distance there [m].
        move: The move.
    """
    # How far any point of the body moves at most: the way of the origin, and the turn at the distance `reach`.
    travel = np.sqrt(move.ahead * move.ahead + move.left * move.left) + np.abs(move.turn) * task.shape.reach
    limit = max(task.options.clearance, travel + task.padding)
    share, least = 0.0, limit
    while share < 1.0:
        step = max(room - task.padding, task.padding, LEAST_STEP)
        share = min(share + step / travel, 1.0)
        there = pose_after(pose, (move.ahead, move.left, move.turn), share)
        room = room_at_pose(task.obstacles, task.shape, there, limit)
        if room < task.padding or room <= 0.0:
            return 0.0, 0.0
        least = min(least, room)
    return least, room


@kernel
def move_to(task: PoseTask, nodes: queue.PoseNodes, node: int) -> Record:
    """Return the move that leads to a pose.

    Writes: task.
    """
    if nodes.move[node] < task.moves.shape[0]:
        found: Record = task.moves[nodes.move[node]]
        return found
    # The straight move to the goal is not in the list: it is computed again, and its number is one past the list.
    parent = nodes.pose[nodes.parent[node]]
    lay_last(task.aim, task.moves, LAST_CELLS * task.cell, (parent[0], parent[1], parent[2]), task.last)
    return task.last


@kernel
def look_at(task: PoseTask, nodes: queue.PoseNodes, node: int) -> bool:
    """Return whether the move that leads to a pose is free; its cost grows by how near to obstacles it is.

    Writes: nodes.
    """
    parent, move = nodes.parent[node], move_to(task, nodes, node)
    before = (nodes.pose[parent, 0], nodes.pose[parent, 1], nodes.pose[parent, 2])
    least, nodes.room[node] = room_along(task, before, nodes.room[parent], move)
    if least <= 0.0:
        return False
    if least < task.options.clearance:
        nodes.cost[node] += NEAR * move.seconds * (1.0 - least / task.options.clearance)
    return True


@kernel
def search_poses(task: PoseTask, start: Pose, nodes: queue.PoseNodes) -> int:
    """Return the number of a pose at the goal, from which ``nodes.parent`` leads back to the start.

    It is ``NOBODY`` if there is no way, and ``GAVE_UP`` if none was found before the memory was full.

    Writes: nodes.

    Args:
        task: What is searched.
        start: Where the body is.
        nodes: Memory; written.
    """
    nodes.closed[:] = queue.NOBODY
    queue.note_pose(nodes, 0, start, 0.0, queue.NOBODY, queue.NOBODY)
    nodes.room[0] = room_at_pose(task.obstacles, task.shape, start, 1.0)
    # count: poses in memory; size: entries in the queue.
    count, size, n_closed = 1, queue.push(nodes, 0, 0.0, 0), 0
    while size > 0 and n_closed < queue.MOST_CLOSED and count + task.moves.shape[0] < nodes.cost.shape[0]:
        node = queue.pop(nodes, size)
        size -= 1
        here = (nodes.pose[node, 0], nodes.pose[node, 1], nodes.pose[node, 2])
        # A pose that a last move leads to may lie in a closed cell: it ends at the goal, not anywhere in the cell.
        cell, is_last = cell_of(task, here), nodes.move[node] == task.moves.shape[0]
        if not is_last and queue.is_closed(nodes.closed, cell):
            continue
        # Only now is the move tested. If nearness to obstacles makes it cost more, it goes back into the queue.
        if nodes.room[node] == queue.UNKNOWN:
            cost = nodes.cost[node]
            if not look_at(task, nodes, node):
                continue
            if nodes.cost[node] > cost:
                size = queue.push(nodes, size, nodes.cost[node] + GREED * cost_to_go(task, here), node)
                continue
        if aim_gap(task.aim, here) < task.aim.radius:
            return int(node)
        if not is_last:
            queue.close_cell(nodes.closed, cell)
            n_closed += 1
            count, size = expand(task, nodes, node, count, size)
        # Also after a last move: a body that has arrived at the position may still have to turn to the heading.
        if lay_last(task.aim, task.moves, LAST_CELLS * task.cell, here, task.last):
            there = pose_after(here, (task.last.ahead, task.last.left, task.last.turn), 1.0)
            queue.note_pose(nodes, count, there, nodes.cost[node] + task.last.seconds, node, task.moves.shape[0])
            size = queue.push(nodes, size, nodes.cost[count] + GREED * cost_to_go(task, there), count)
            count += 1
    return queue.NOBODY if size == 0 else queue.GAVE_UP


@kernel
def expand(task: PoseTask, nodes: queue.PoseNodes, node: int, count: int, size: int) -> tuple[int, int]:
    """Put the poses to which a body can move from a pose into the queue; return the new counts of poses and queue.

    Writes: nodes.
    """
    here = (nodes.pose[node, 0], nodes.pose[node, 1], nodes.pose[node, 2])
    # The start has no move before it.
    gear, turn = 0, 0.0
    if nodes.move[node] != queue.NOBODY:
        gear, turn = task.moves[nodes.move[node]].gear, task.moves[nodes.move[node]].turn
    for k in range(task.moves.shape[0]):
        move = task.moves[k]
        there = pose_after(here, (move.ahead, move.left, move.turn), 1.0)
        cell = cell_of(task, there)
        if cell < 0 or queue.is_closed(nodes.closed, cell):
            continue
        # Untested: the move may still turn out to be blocked.
        rest = cost_to_go(task, there)
        if not rest < np.inf:
            continue
        cost = nodes.cost[node] + seconds_of(task.options, move, gear, turn)
        queue.note_pose(nodes, count, there, cost, node, k)
        size = queue.push(nodes, size, cost + GREED * rest, count)
        count += 1
    return count, size
