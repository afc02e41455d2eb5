"""Route: where the shortest way to the goal leads, as somebody knows who has a map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Bytes, CellMap, Flags, Floats, Ints, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.geometry.angles import turned
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import Obstacles
from irsim_gym.paths.geodesic import search_ways
from irsim_gym.paths.grid import Grid, Search
from irsim_gym.paths.spread import PARENT
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.scaling import unit
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Term, forget
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

CELL = 0.1
"""Side of the cells [m] where none is given, and the world is small enough."""
FINEST = 200
"""Most cells along the longer side of the world, unless a side is given."""
ENTRY = 4
"""How many cells around the agent's own are looked at for a free one."""


@kind
class Route:
    """Direction of a point ahead on the shortest way to the next goal, as cosine and sine, and the way's length.

    The way leads around what never moves, at the agent's reach, over free cells; it is found when the goal is new. The
    length comes over the world's diagonal, cut to 1. Where no way is known both are those of the straight one.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = True
    needs_scan: ClassVar[bool] = False

    ahead: float = option(1.0, gt=0.0, unit="m", meaning="How far ahead on the way the point lies.")
    cell: float | None = option(
        None, gt=0.0, unit="m", meaning="Side of the cells; none: 0.1 m, or a 200th of the world's longer side."
    )

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return the ways, ``(n_worlds, n_agents, n_cells)``, the goals they lead to, the grid, and scratch memory."""
        bounds = simulation.model.bounds
        side = max(float(bounds[2] - bounds[0]), float(bounds[3] - bounds[1]))
        grid = Grid.over(bounds, max(CELL, side / FINEST) if self.cell is None else self.cell)
        slots, n_agents = simulation.shards.n_slots, len(agents)
        shape = (simulation.n_worlds, n_agents, grid.rows * grid.columns)
        return {
            "grid": np.array([grid.origin_x, grid.origin_y, grid.cell]),
            "onward": np.full(shape, -1, np.int32),
            "length": np.full(shape, np.inf, np.float32),
            "target": np.full((simulation.n_worlds, n_agents, 2), np.nan),
            **{name: np.stack([part] * slots) for name, part in grid.search()._asdict().items()},
            "blocks": np.zeros((slots, len(simulation.scenario.bodies)), np.bool_),
        }

    def bounds(self, term: Term, model: WorldModel) -> tuple[Rays, Rays]:
        """Return the bounds of the three elements."""
        return np.array([-1.0, -1.0, 0.0], np.float32), np.ones(3, np.float32)

    def columns(self, term: Term, model: WorldModel, agent: int) -> Sequence[Columns]:
        """Return what the three elements are."""
        full = float(np.hypot(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]))
        point = f"of the direction of the point {self.ahead:g} m ahead on the shortest way"
        return [
            Columns(f"cosine {point}", "1 straight ahead, -1 straight behind"),
            Columns(f"sine {point}", "1 to the left, -1 to the right"),
            Columns("length s of the shortest way to the next goal", f"s / {full:.3g} m, at most 1"),
        ]

    @staticmethod
    def begin(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Forget the goals, so that all ways are found anew."""
        forget(term.arrays["target"], np.nan, episode, shard)

    @staticmethod
    def write(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Find the ways to goals that are new, and write the three elements."""
        table, slot = term.arrays, shard.slot
        find_ways(
            shard.worlds,
            term.agents,
            model,
            state,
            model.cells,
            table["grid"],
            table["blocked"][slot],
            table["field"][slot],
            table["queue"][slot],
            table["blocks"][slot],
            table["target"],
            table["onward"],
            table["length"],
        )
        write_route(
            shard.worlds,
            term.agents,
            term.column,
            term.options.ahead,
            model,
            state,
            episode,
            table["grid"],
            table["blocked"].shape[2],
            table["onward"],
            table["length"],
        )


@kernel
def find_ways(
    worlds: Ints,
    agents: Ints,
    model: WorldModel,
    state: WorldState,
    cells: CellMap | None,
    grid: Floats,
    blocked: Bytes,
    field: Floats,
    queue: Ints,
    blocks: Flags,
    target: Floats,
    onward: Ints,
    length: Rays,
) -> None:
    """Write for each free cell the next one on the way to the goal and how long the way is, where the goal is new."""
    for w in worlds:
        for a in range(agents.shape[0]):
            own = agents[a]
            goal_x, goal_y = state.goal[w, own, 0], state.goal[w, own, 1]
            if goal_x == target[w, a, 0] and goal_y == target[w, a, 1]:
                continue
            target[w, a, 0], target[w, a, 1] = goal_x, goal_y
            for b in range(blocks.shape[0]):
                blocks[b] = model.present[w, b] and model.stands[b] and not model.unobstructed[b] and b != own
            obstacles, radius = Obstacles(model, state, w, blocks, cells), model.reach[row_of(model.reach, w), own]
            place = Grid(grid[0], grid[1], grid[2], field.shape[1], field.shape[0])
            search_ways(obstacles, radius, (goal_x, goal_y), place, Search(blocked, field, queue))
            known = field.reshape(-1)
            for k in range(known.shape[0]):
                length[w, a, k] = np.float32(known[k])
                onward[w, a, k] = np.int32(queue[PARENT, k])


@kernel
def write_route(
    worlds: Ints,
    agents: Ints,
    column: int,
    ahead: float,
    model: WorldModel,
    state: WorldState,
    episode: EpisodeState,
    grid: Floats,
    columns: int,
    onward: Ints,
    length: Rays,
) -> None:
    """Write cosine and sine of the way's direction, (1, 0) at the goal itself, and its length over the diagonal."""
    width, height = model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            x, y = state.pose[w, b, 0], state.pose[w, b, 1]
            to_x, to_y = state.goal[w, b, 0], state.goal[w, b, 1]
            way = np.sqrt((to_x - x) * (to_x - x) + (to_y - y) * (to_y - y))
            first = entry(length[w, a], grid, columns, x, y)
            if first >= 0 and float(length[w, a, first]) > ahead:
                way = float(length[w, a, first])
                to_x, to_y = point_ahead(onward[w, a], grid, columns, first, ahead, to_x, to_y)
            dx, dy = to_x - x, to_y - y
            far = np.sqrt(dx * dx + dy * dy)
            cosine, sine = turned(state.pose[w, b, 2], state.direction[w, b])
            row = episode.observation[w, a, column : column + 3]
            row[0] = unit((dx * cosine + dy * sine) / far if far > 0.0 else 1.0)
            row[1] = unit((dy * cosine - dx * sine) / far if far > 0.0 else 0.0)
            row[2] = unit(way / np.sqrt(width * width + height * height))


@kernel
def entry(length: Rays, grid: Floats, columns: int, x: float, y: float) -> int:
    """Return the number of the cell nearest to a point from which a way is known; -1 if none is near."""
    rows = length.shape[0] // columns
    own_row, own_column = int(np.floor((y - grid[1]) / grid[2])), int(np.floor((x - grid[0]) / grid[2]))
    best, found = np.inf, -1
    for row in range(max(own_row - ENTRY, 0), min(own_row + ENTRY + 1, rows)):
        for column in range(max(own_column - ENTRY, 0), min(own_column + ENTRY + 1, columns)):
            if length[row * columns + column] == np.inf:
                continue
            dx = grid[0] + (column + 0.5) * grid[2] - x
            dy = grid[1] + (row + 0.5) * grid[2] - y
            if dx * dx + dy * dy < best:
                best, found = dx * dx + dy * dy, row * columns + column
    return found


@kernel
def point_ahead(
    onward: Ints, grid: Floats, columns: int, first: int, ahead: float, goal_x: float, goal_y: float
) -> tuple[float, float]:
    """Return the point [m] so far ahead on the way from a cell, to the next cell; the goal where the way is shorter."""
    here, driven = first, 0.0
    x, y = grid[0] + (here % columns + 0.5) * grid[2], grid[1] + (here // columns + 0.5) * grid[2]
    while driven < ahead:
        here = int(onward[here])
        if here < 0:
            return goal_x, goal_y
        next_x, next_y = grid[0] + (here % columns + 0.5) * grid[2], grid[1] + (here // columns + 0.5) * grid[2]
        driven += np.sqrt((next_x - x) * (next_x - x) + (next_y - y) * (next_y - y))
        x, y = next_x, next_y
    return x, y
