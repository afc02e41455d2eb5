"""Plans a member's path over poses, and writes it into the tables."""

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Floats, Pose, Record, Records
from irsim_gym.bodies.behaviors.hybrid_astar.costs import COARSE, Aim, aim_gap, cost_without_obstacles
from irsim_gym.bodies.behaviors.hybrid_astar.moves import MOST_MOVES, lay_moves
from irsim_gym.bodies.behaviors.hybrid_astar.queue import NOBODY, PoseNodes, nodes_of
from irsim_gym.bodies.behaviors.hybrid_astar.search import LAST_CELLS, PoseTask, move_to, search_poses
from irsim_gym.bodies.behaviors.hybrid_astar.tables import (
    AHEAD,
    GEAR,
    HEADING,
    LEFT,
    MOST_PIECES,
    NEARER,
    TURN,
    PoseTables,
    X,
    Y,
    inner_radius_of,
)
from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.simulator.cell_paths.outline_room import PoseShape, largest_disc, room_at_pose
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.geodesic import search_ways
from irsim_gym.simulator.paths.grid import Grid, Search
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, STATE, Model
from irsim_gym.simulator.world.names import State, kernel, row_of
from irsim_gym.simulator.world.outline import own_outline

PADDING = 0.02
"""Minimum distance of paths from obstacles [m], unless the body starts closer."""
TIGHT = 0.999
"""Share of its distance from an obstacle that a body keeps if it starts closer."""
ATTEMPTS = 2
"""Number of cell sizes that are tried, each half of the previous one, until a path is found or the memory is full."""


@kernel
def aim_of(model: Model, state: State, w: int, b: int) -> Aim:
    """Return the goal of a search: that of the body, with less tolerance than arrival has.

    Reads: model (arrive_mode, goal_threshold), state (goal).
    """
    goal, near = state.goal[w, b], NEARER * model.goal_threshold[row_of(model.goal_threshold, w), b]
    return Aim(goal[0], goal[1], goal[2] if model.arrive_mode[b] == STATE else np.nan, near)


@kernel
def shape_of(model: Model, w: int, b: int, tables: PoseTables, slot: int) -> PoseShape:
    """Return the outline of body b of world w, with room for it at a pose.

    Reads: model (disc_count, disc_start, local_discs, local_segments, reach, segment_count, segment_start, solid),
        tables (discs, segments).
    """
    own = own_outline(model, w, b)
    laid = BodyOutline(tables.segments[slot], 0, own.n_segments, tables.discs[slot], 0, own.n_discs, own.solid)
    return PoseShape(own, laid, model.reach[row_of(model.reach, w), b])


@kernel
def find_poses(obstacles: Obstacles, options: Record, moving: Moving, tables: PoseTables, slot: int, b: int) -> None:
    """Write a member's way over poses to its goal; one of no moves where none is found.

    Reads: tables (cell, costs, discs, grid, moves, nodes, segments, table).
    Writes: tables (count, goal, piece, pieces, share).

    Args:
        obstacles: What stands in the way; the world is theirs.
        options: Those of ``HybridAstar``.
        moving: What the body does and can do.
        tables: Written.
        slot: Whose scratch memory.
        b: The body.
    """
    model, state, w, m = obstacles.model, obstacles.state, obstacles.w, options.index
    aim, start = aim_of(model, state, w, b), (moving.pose[0], moving.pose[1], moving.pose[2])
    for axis in range(3):
        tables.goal[w, m, axis] = state.goal[w, b, axis]
    tables.count[w, m], tables.piece[w, m], tables.share[w, m] = 0, 0, 0.0
    # A body that cannot turn never arrives with another heading than it has now.
    if not (turns(moving) or aim_gap(aim, (aim.x, aim.y, start[2])) < aim.radius):
        return
    grid = tables.grid
    if not may_arrive(obstacles, aim, start, largest_disc(model, w, b), grid.grid, tables.cell[m]):
        return
    search = Search(grid.blocked[slot], grid.field[slot], grid.queue[slot])
    # The field is that of the body's inner disc less half a cell's diagonal: wherever the body fits, that disc fits at
    # the centre of the cell. `radius` makes it the disc that mark_blocked tests there, see paths.grid.
    open_radius = max(inner_radius_of(model, w, b) - np.sqrt(0.5) * grid.grid.cell, 0.0)
    radius = np.sqrt(max(open_radius * open_radius - 0.5 * grid.grid.cell * grid.grid.cell, 0.0))
    search_ways(obstacles, radius, (aim.x, aim.y), grid.grid, search)
    shape = shape_of(model, w, b, tables, slot)
    nodes, costs = nodes_of(tables.nodes, slot), tables.costs[tables.table[m]]
    # A body that begins closer than PADDING has to get away.
    padding = min(PADDING, TIGHT * room_at_pose(obstacles, shape, start, 1.0))
    cell, costs_cell, beyond = tables.cell[m], COARSE * tables.cell[m], np.inf
    for attempt in range(2 * ATTEMPTS):
        if attempt == ATTEMPTS:
            # A body with wide turns may have to leave the table of costs, and come back, for a goal close by. Searches
            # that include such ways take much longer, so they come last, and only where the body is in the table.
            if cost_without_obstacles(aim, costs, costs_cell, start) == 0.0:
                return
            cell, beyond = tables.cell[m], greatest_of(costs)
        moves = tables.moves[slot][: lay_moves(moving, cell, tables.moves[slot])]
        task = PoseTask(
            obstacles, shape, padding, aim, moves, tables.moves[slot][MOST_MOVES - 1], fastest_of(moves), cell, costs,
            costs_cell, beyond, grid.grid, search.field, options,
        )  # fmt: skip
        end = search_poses(task, start, nodes)
        if end >= 0:
            write_way(task, nodes, end, tables, w, m)
        # Finer cells, or more of them, take more memory still.
        if end != NOBODY:
            return
        cell *= 0.5


@kernel
def may_arrive(obstacles: Obstacles, aim: Aim, start: Pose, inner: float, grid: Grid, cell: float) -> bool:
    """Return whether a body may arrive at a goal. False is a proof that it cannot, where a search would take long.

    Args:
        obstacles: What stands in the way.
        aim: The goal.
        start: Where the body is.
        inner: Radius of a disc about its origin within it [m].
        grid: The grid of the world.
        cell: Side of the cells of a search [m].
    """
    # Wherever the body arrives, its inner disc covers one about the goal, whose radius is less by the tolerance.
    goal, covered = (aim.x, aim.y), inner - aim.radius
    if covered > 0.0 and not way_is_free(obstacles, covered, goal, goal):
        return False
    # A search stays within the world, but for a last move; cells may reach beyond the world's edge by one.
    beyond_x = max(grid.origin_x - aim.x, aim.x - grid.origin_x - grid.columns * grid.cell, 0.0)
    beyond_y = max(grid.origin_y - aim.y, aim.y - grid.origin_y - grid.rows * grid.cell, 0.0)
    dx, dy, last = aim.x - start[0], aim.y - start[1], (LAST_CELLS + 2.0) * cell + aim.radius
    return bool(min(beyond_x * beyond_x + beyond_y * beyond_y, dx * dx + dy * dy) <= last * last)


@kernel
def turns(moving: Moving) -> bool:
    """Return whether a body can turn."""
    return bool(moving.drive in (DIFFERENTIAL, ACKERMANN, OMNI_ANGULAR))


@kernel
def fastest_of(moves: Records) -> float:
    """Return the greatest speed of moves [m/s]."""
    fastest = 0.0
    for k in range(moves.shape[0]):
        move = moves[k]
        fastest = max(fastest, np.sqrt(move.ahead * move.ahead + move.left * move.left) / move.seconds)
    return fastest


@kernel
def greatest_of(costs: Floats) -> float:
    """Return the greatest finite cost in a table [s]."""
    greatest = 0.0
    for cost in costs.flat:
        greatest = max(greatest, cost if cost < np.inf else 0.0)
    return greatest


@kernel
def write_way(task: PoseTask, nodes: PoseNodes, end: int, tables: PoseTables, w: int, m: int) -> None:
    """Write the moves that lead to a pose that was found, the first ones if they are too many; none for ``NOBODY``.

    Writes: task, tables (count, pieces).
    """
    count, node = 0, end
    while node != NOBODY and nodes.parent[node] != NOBODY:
        count, node = count + 1, nodes.parent[node]
    # From the end to the start; pieces beyond the memory are passed over.
    tables.count[w, m], node, k = min(count, MOST_PIECES), end, count
    while k > 0:
        k -= 1
        if k < MOST_PIECES:
            write_piece(task, nodes, node, tables.pieces[w, m, k])
        node = nodes.parent[node]


@kernel
def write_piece(task: PoseTask, nodes: PoseNodes, node: int, piece: Floats) -> None:
    """Write the move that leads to a pose.

    Writes: piece.
    """
    move, before = move_to(task, nodes, node), nodes.pose[nodes.parent[node]]
    piece[X], piece[Y], piece[HEADING] = before[0], before[1], before[2]
    piece[AHEAD], piece[LEFT], piece[TURN], piece[GEAR] = move.ahead, move.left, move.turn, move.gear
