"""Route: direction and length of the shortest path to the goal, from the map."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Cells, Flags, Floats, Ints, Point, Rays, Spans
from irsim_gym.simulator.geometry.angles import turned
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.paths.geodesic import search_ways
from irsim_gym.simulator.paths.grid import Grid, Search, centre
from irsim_gym.simulator.paths.spread import PARENT
from irsim_gym.simulator.world.names import Model, Shard, State, Struct, kernel, kind, option, row_of
from irsim_gym.tasks.observations.seen_map.way_columns import ObservesWay, way_columns, write_direction
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Needs, Simulation, Term, diagonal, forget, unit

CELL = 0.1
"""Default cell size [m], if the world is small enough."""
FINEST = 200
"""Maximum number of cells along the longer side of the world with the default cell size."""
ENTRY = 4
"""Search radius for a free cell around the agent's own [cells]."""


@dataclass
class RouteWays(Struct):
    """The paths to the agents' goals on a grid, and scratch memory for the search.

    Attributes:
        grid: The grid.
        onward: Number of the next cell on the path, -1 at its end, shape ``(n_worlds, n_agents, n_cells)``.
        length: Length of the path from each cell [m], infinite without one, shape ``(n_worlds, n_agents, n_cells)``.
        target: The goals [m] of the paths, shape ``(n_worlds, n_agents, 2)``.
        blocked: Scratch, see ``Search``; as in all following arrays, the first axis is the slot.
        field: Scratch, see ``Search``.
        queue: Scratch, see ``Search``.
        blocks: Scratch: flags of bodies that are obstacles, shape ``(n_slots, n_bodies)``.
    """

    grid: Grid
    onward: Spans
    length: Rays
    target: Floats
    blocked: Bytes
    field: Floats
    queue: Ints
    blocks: Flags


@kind
class Route(ObservesWay):
    """Direction of a point ahead on the shortest path to the next goal, as cosine and sine, and the path's length.

    The path avoids everything that never moves, with clearance for the agent's reach, on free cells; it is computed
    when the goal changes. The length is divided by the world's diagonal and clipped to 1. Without a path, both are
    those of the straight line.
    """

    needs: ClassVar[Needs] = ("map_frame", "bodies")

    ahead: float = option(1.0, gt=0.0, unit="m", meaning="Distance of the point along the path.")
    cell: float | None = option(None, gt=0.0, unit="m", meaning="Cell size; default: 0.1 m, or a 200th of the world.")

    def arrays(self, simulation: Simulation, agents: Ints) -> RouteWays:
        """Return the paths, and scratch memory."""
        bounds = simulation.model.bounds
        side = max(float(bounds[2] - bounds[0]), float(bounds[3] - bounds[1]))
        grid = Grid.over(bounds, max(CELL, side / FINEST) if self.cell is None else self.cell)
        slots, n_agents = simulation.shards.n_slots, len(agents)
        shape = (simulation.n_worlds, n_agents, grid.rows * grid.columns)
        search = grid.search()
        return RouteWays(
            grid=grid,
            onward=np.full(shape, -1, np.int32),
            length=np.full(shape, np.inf, np.float32),
            target=np.full((simulation.n_worlds, n_agents, 2), np.nan),
            **{name: np.stack([part] * slots) for name, part in search._asdict().items()},
            blocks=np.zeros((slots, len(simulation.scenario.bodies)), np.bool_),
        )

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        point = f"of the direction of the point {self.ahead:g} m ahead on the shortest path"
        scaled = f"s / {diagonal(model.bounds):.3g} m, at most 1"
        return way_columns(point, "length s of the shortest path to the next goal", scaled)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the goals, so that all paths are computed again."""
        forget(term.arrays.target, np.nan, episode, shard)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Compute the paths to new goals, and write the three elements."""
        find_ways(shard.worlds, shard.slot, term.agents, term.arrays, model, model.cells, state)
        write_route(shard.worlds, term.bound, term.arrays, model, state, episode)


@kernel
def find_ways(worlds: Ints, slot: int, agents: Ints, ways: RouteWays, model: Model, cells: Cells, state: State) -> None:
    """Compute the paths to new goals: the next cell and the length of the path for each free cell.

    Reads: ways (blocked, blocks, field, grid, queue, target), model (present, reach, stands, unobstructed), state
        (goal).
    Writes: ways (blocks, length, onward, target).
    """
    blocked, field, queue, blocks = ways.blocked[slot], ways.field[slot], ways.queue[slot], ways.blocks[slot]
    for w in worlds:
        for a in range(agents.shape[0]):
            body, target = agents[a], ways.target[w, a]
            goal_x, goal_y = state.goal[w, body, 0], state.goal[w, body, 1]
            if goal_x == target[0] and goal_y == target[1]:
                continue
            target[0], target[1] = goal_x, goal_y
            mark_standing(model, w, body, blocks)
            obstacles = Obstacles(model, state, w, blocks, cells, None)
            radius = model.reach[row_of(model.reach, w), body]
            search_ways(obstacles, radius, (goal_x, goal_y), ways.grid, Search(blocked, field, queue))
            lengths = field.reshape(-1)
            for k in range(lengths.shape[0]):
                ways.length[w, a, k] = np.float32(lengths[k])
                ways.onward[w, a, k] = np.int32(queue[PARENT, k])


@kernel
def write_route(worlds: Ints, term: Bound, ways: RouteWays, model: Model, state: State, episode: EpisodeState) -> None:
    """Write cosine and sine of the path's direction, (1, 0) at the goal itself, and its length over the diagonal.

    Reads: term (agents, column, options), ways (grid, length, onward), model (bounds), state (direction, goal, pose).
    Writes: episode (observation).
    """
    ahead, column, full = term.options[0].ahead, term.column, diagonal(model.bounds)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b, length = term.agents[a], ways.length[w, a]
            x, y = state.pose[w, b, 0], state.pose[w, b, 1]
            to_x, to_y = state.goal[w, b, 0], state.goal[w, b, 1]
            way = np.sqrt((to_x - x) * (to_x - x) + (to_y - y) * (to_y - y))
            first = entry(length, ways.grid, x, y)
            if first >= 0 and float(length[first]) > ahead:
                way = float(length[first])
                to_x, to_y = point_ahead(ways.onward[w, a], ways.grid, first, ahead, to_x, to_y)
            row = episode.observation[w, a, column : column + 3]
            write_direction(row, (x, y), turned(state.pose[w, b, 2], state.direction[w, b]), (to_x, to_y))
            row[2] = unit(way / full)


@kernel
def entry(length: Rays, grid: Grid, x: float, y: float) -> int:
    """Return the number of the nearest cell with a path to the goal; -1 if none is near."""
    rows, columns = grid.rows, grid.columns
    own_row, own_column = int(np.floor((y - grid.origin_y) / grid.cell)), int(np.floor((x - grid.origin_x) / grid.cell))
    best, gate = np.inf, -1
    for row in range(max(own_row - ENTRY, 0), min(own_row + ENTRY + 1, rows)):
        for column in range(max(own_column - ENTRY, 0), min(own_column + ENTRY + 1, columns)):
            if length[row * columns + column] == np.inf:
                continue
            centre_x, centre_y = centre(grid, row, column)
            dx, dy = centre_x - x, centre_y - y
            if dx * dx + dy * dy < best:
                best, gate = dx * dx + dy * dy, row * columns + column
    return gate


@kernel
def point_ahead(onward: Spans, grid: Grid, first: int, ahead: float, goal_x: float, goal_y: float) -> Point:
    """Return the first cell centre on a path that is at least ``ahead`` [m] away; the goal if the path is shorter."""
    columns, cell, driven = grid.columns, first, 0.0
    x, y = centre(grid, cell // columns, cell % columns)
    while driven < ahead:
        cell = int(onward[cell])
        if cell < 0:
            return goal_x, goal_y
        next_x, next_y = centre(grid, cell // columns, cell % columns)
        driven += np.sqrt((next_x - x) * (next_x - x) + (next_y - y) * (next_y - y))
        x, y = next_x, next_y
    return x, y
