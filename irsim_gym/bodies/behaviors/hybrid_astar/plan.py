"""Plans a member's path over poses, and writes it into the tables."""

import numpy as np

from irsim_gym.bodies.behaviors.hybrid_astar.last import Aim
from irsim_gym.bodies.behaviors.hybrid_astar.moves import MOST_MOVES, lay_moves
from irsim_gym.bodies.behaviors.hybrid_astar.queue import NOBODY, PoseMemory
from irsim_gym.bodies.behaviors.hybrid_astar.search import LAST_CELLS, PoseTask, search_poses
from irsim_gym.bodies.behaviors.hybrid_astar.tables import MOST_PIECES, PoseTables, inner_radius_of
from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.simulator.cell_paths.outline_room import PoseShape, largest_disc, room_at_pose
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.geodesic import search_ways
from irsim_gym.simulator.paths.grid import Grid, Search
from irsim_gym.simulator.world.model import STATE
from irsim_gym.simulator.world.names import BodyOutline, Model, Pose, Record, State, kernel, own_outline, row_of

NEARER = 0.6
"""Share of the arrival threshold within which paths end."""
PADDING = 0.02
"""Minimum distance of paths from obstacles [m], unless the body starts closer."""
TIGHT = 0.999
"""Share of its distance from an obstacle that a body keeps if it starts closer."""
ATTEMPTS = 3
"""Number of cell sizes that are tried: each half of the previous one if there is no path, or twice as large if the
memory is full first."""


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

    Reads: tables (cell, discs, grid, memory, moves, segments).
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
    grid, cell, moves = tables.grid, tables.cell[m], tables.moves[slot]
    if not may_arrive(obstacles, aim, start, largest_disc(model, w, b), grid.grid, cell):
        return
    search = Search(grid.blocked[slot], grid.field[slot], grid.queue[slot])
    # The field is that of the body's inner disc less half a cell's diagonal: wherever the body fits, that disc fits at
    # the centre of the cell. `radius` makes it the disc that mark_blocked tests there, see paths.grid.
    open_radius = max(inner_radius_of(model, w, b) - np.sqrt(0.5) * grid.grid.cell, 0.0)
    radius = np.sqrt(max(open_radius * open_radius - 0.5 * grid.grid.cell * grid.grid.cell, 0.0))
    search_ways(obstacles, radius, (aim.x, aim.y), grid.grid, search)
    shape, parts = shape_of(model, w, b, tables, slot), tables.memory
    memory = PoseMemory(parts.nodes[slot], parts.key[slot], parts.item[slot], parts.closed[slot])
    # A body that begins closer than PADDING has to get away.
    padding = min(PADDING, TIGHT * room_at_pose(obstacles, shape, start, 1.0))
    fastest = max(moving.high[0], -moving.low[0])
    first = NOBODY
    for attempt in range(ATTEMPTS):
        n_moves = lay_moves(moving, cell, moves)
        task = PoseTask(
            obstacles, shape, padding, options.clearance, aim, moves[:n_moves], moves[MOST_MOVES - 1], fastest, cell,
            grid.grid, search.field,
        )  # fmt: skip
        end = search_poses(task, start, memory)
        if end >= 0:
            write_way(memory, end, tables, w, m)
        first = end if attempt == 0 else first
        # Never back to a size that has been tried.
        if end >= 0 or end != first:
            return
        cell *= 0.5 if end == NOBODY else 2.0


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
def write_way(memory: PoseMemory, end: int, tables: PoseTables, w: int, m: int) -> None:
    """Write the moves that lead to a pose that was found, the first ones if they are too many.

    Writes: tables (count, pieces).
    """
    nodes, pieces, count, k = memory.nodes, tables.pieces[w, m], 0, end
    while nodes[k].parent != NOBODY:
        count, k = count + 1, nodes[k].parent
    tables.count[w, m], k = min(count, MOST_PIECES), end
    # From the end to the start; pieces beyond the memory are passed over.
    for i in range(count - 1, -1, -1):
        node, before = nodes[k], nodes[nodes[k].parent]
        if i < MOST_PIECES:
            pieces[i].x, pieces[i].y, pieces[i].heading = before.x, before.y, before.heading
            pieces[i].ahead, pieces[i].turn, pieces[i].gear = node.ahead, node.turn, node.gear
        k = node.parent
