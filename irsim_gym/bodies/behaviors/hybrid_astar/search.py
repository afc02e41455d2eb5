"""Hybrid A* (Dolgov, Thrun, Montemerlo, Diebel 2008): a path over poses on which a body's outline touches nothing.

The search runs over cells of position and heading, and keeps the pose that it reached in each cell. What is left counts
as the way of a disc within the body around the obstacles. Moves are tested only when their poses are next in the queue.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Pose, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.hybrid_astar import queue
from irsim_gym.bodies.behaviors.hybrid_astar.last import Aim, aim_gap, lay_last
from irsim_gym.bodies.behaviors.hybrid_astar.moves import N_HEADINGS, pose_after, write_move
from irsim_gym.simulator.cell_paths.outline_room import PoseShape, room_at_pose
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.paths.geodesic import field_at
from irsim_gym.simulator.paths.grid import Grid

CHANGE = 0.5
"""Cost of a change of the gear [s]."""
STEERING = 0.3
"""Cost of a change of how far moves turn, within a gear [s/rad]."""
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
        clearance: Closer to obstacles than this, time costs more [m].
        aim: The goal.
        moves: The body's moves, shape ``(n_moves,)``.
        last: Scratch: the move straight to the goal.
        fastest: The body's maximum speed [m/s].
        cell: Cell size of the search [m].
        grid: The grid of ``field``.
        field: Distance of a disc within the body from the goal [m].
    """

    obstacles: Obstacles
    shape: PoseShape
    padding: float
    clearance: float
    aim: Aim
    moves: Records
    last: Record
    fastest: float
    cell: float
    grid: Grid
    field: Floats


@kernel
def cost_to_go(task: PoseTask, pose: Pose) -> float:
    """Return what the way from a pose to the goal costs at least, but for how coarse cells are [s]."""
    # Where the field knows no way, as in cells beside obstacles, the straight line is a lower bound.
    far = field_at(task.field, task.grid, pose[0], pose[1])
    if not far < np.inf:
        dx, dy = pose[0] - task.aim.x, pose[1] - task.aim.y
        far = np.sqrt(dx * dx + dy * dy)
    # The goal is an area: arriving at its edge is enough.
    return float(max(far - task.aim.radius, 0.0) / task.fastest)


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
    travel = np.abs(move.ahead) + np.abs(move.turn) * task.shape.reach
    limit = max(task.clearance, travel + task.padding)
    share, least = 0.0, limit
    while share < 1.0:
        step = max(room - task.padding, task.padding, LEAST_STEP)
        share = min(share + step / travel, 1.0)
        room = room_at_pose(task.obstacles, task.shape, pose_after(pose, move.ahead, move.turn, share), limit)
        if room < task.padding or room <= 0.0:
            return 0.0, 0.0
        least = min(least, room)
    return least, room


@kernel
def is_free(task: PoseTask, nodes: Records, node: Record) -> bool:
    """Return whether the move that leads to a pose is free; its cost grows by how near to obstacles it is.

    Writes: task, node.
    """
    before = nodes[node.parent]
    least, node.room = room_along(task, queue.pose_of(before), before.room, node)
    if least < task.clearance:
        node.cost += NEAR * node.seconds * (1.0 - least / task.clearance)
    return bool(least > 0.0)


@kernel
def add_pose(
    task: PoseTask, memory: queue.PoseMemory, parent: int, move: Record, ends: bool, count: int, size: int
) -> tuple[int, int]:
    """Put the pose to which a move leads from another one into the queue; return the new counts of poses and queue.

    Writes: memory.

    Args:
        task: The search.
        memory: Written.
        parent: Number of the pose before it.
        move: The move; it is tested later, and may turn out to be blocked.
        ends: Whether it leads straight to the goal. Such a pose may lie in a closed cell: it ends at the goal, not
            anywhere in the cell.
        count: Number of poses in memory.
        size: Number of entries in the queue.
    """
    node, before = memory.nodes[count], memory.nodes[parent]
    there = pose_after(queue.pose_of(before), move.ahead, move.turn, 1.0)
    cell = cell_of(task, there)
    if not ends and (cell < 0 or queue.is_closed(memory.closed, cell)):
        return count, size
    node.x, node.y, node.heading = there
    node.cost, node.room, node.parent, node.ends = before.cost + move.seconds, queue.UNKNOWN, parent, ends
    # Within a gear, steering has its price; a change of gear has its own, and comes with any steering.
    if before.gear == move.gear:
        node.cost += STEERING * np.abs(move.turn - before.turn)
    elif parent > 0:
        node.cost += CHANGE
    write_move(node, move.ahead, move.turn, move.seconds, move.gear)
    return count + 1, queue.push(memory, size, node.cost + GREED * cost_to_go(task, there), count)


@kernel
def search_poses(task: PoseTask, start: Pose, memory: queue.PoseMemory) -> int:
    """Return the number of a pose at the goal, from which ``parent`` leads back to the start.

    It is ``NOBODY`` if there is no way, and ``GAVE_UP`` if none was found before the memory was full.

    Writes: memory.

    Args:
        task: What is searched.
        start: Where the body is.
        memory: Written.
    """
    nodes, first = memory.nodes, memory.nodes[0]
    memory.closed[:] = queue.NOBODY
    first.x, first.y, first.heading = start
    first.cost, first.parent, first.gear, first.ends = 0.0, queue.NOBODY, 0, False
    first.room = room_at_pose(task.obstacles, task.shape, start, 1.0)
    # count: poses in memory; size: entries in the queue.
    count, size, n_closed = 1, queue.push(memory, 0, 0.0, 0), 0
    while size > 0 and n_closed < queue.MOST_CLOSED and count + task.moves.shape[0] < nodes.shape[0]:
        k = queue.pop(memory, size)
        size -= 1
        node, here = nodes[k], queue.pose_of(nodes[k])
        cell = cell_of(task, here)
        if not node.ends and queue.is_closed(memory.closed, cell):
            continue
        # Only now is the move tested. If nearness to obstacles makes it cost more, it goes back into the queue.
        if node.room == queue.UNKNOWN:
            cost = node.cost
            if not is_free(task, nodes, node):
                continue
            if node.cost > cost:
                size = queue.push(memory, size, node.cost + GREED * cost_to_go(task, here), k)
                continue
        if aim_gap(task.aim, here) < task.aim.radius:
            return int(k)
        if not node.ends:
            queue.close_cell(memory.closed, cell)
            n_closed += 1
            for m in range(task.moves.shape[0]):
                count, size = add_pose(task, memory, k, task.moves[m], False, count, size)
        # Also after a last move: a body that has arrived at the position may still have to turn to the heading.
        if lay_last(task.aim, task.moves, LAST_CELLS * task.cell, here, task.last):
            count, size = add_pose(task, memory, k, task.last, True, count, size)
    return queue.NOBODY if size == 0 else queue.GAVE_UP
