"""Distances to the goal around what never moves, for rewards: one field for each agent of each world."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Bytes, CellMap, Flags, Floats, Ints
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import Obstacles
from irsim_gym.paths.geodesic import distance_field, field_at
from irsim_gym.paths.grid import Grid, Search
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Term
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState


def field_arrays(simulation: Simulation, n_agents: int, cell: float) -> dict[str, NDArray[Any]]:
    """Return the fields, ``(n_worlds, n_agents, rows, columns)`` [m], their grid, and scratch for each shard."""
    grid = Grid.over(simulation.model.bounds, cell)
    slots, n_bodies = simulation.shards.n_slots, len(simulation.scenario.bodies)
    shape = (simulation.n_worlds, n_agents, grid.rows, grid.columns)
    return {
        "grid": np.array([grid.origin_x, grid.origin_y, grid.cell]),
        "field": np.full(shape, np.inf),
        **{name: np.stack([part] * slots) for name, part in grid.search()._asdict().items() if name != "field"},
        "blocks": np.zeros((slots, n_bodies), np.bool_),
    }


def note_fields(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
    """Draw the fields of agents whose episode begins or whose goal has changed, and note goals and distances."""
    table, slot = term.arrays, shard.slot
    draw_fields(
        shard.worlds,
        term.agents,
        model,
        state,
        episode,
        model.cells,
        table["grid"],
        table["blocked"][slot],
        table["queue"][slot],
        table["blocks"][slot],
        table["target"],
        table["field"],
        table["potential"],
    )


def pay_field_gain(term: Term, model: WorldModel, state: WorldState, shard: Shard, out: Floats) -> None:
    """Write the weighted way gained, over the world's diagonal, and note the new distances."""
    table = term.arrays
    pay_gain(
        shard.worlds,
        term.agents,
        term.column,
        term.options.weight,
        model,
        state,
        table["grid"],
        table["field"],
        table["potential"],
        out,
    )


@kernel
def draw_fields(
    worlds: Ints,
    agents: Ints,
    model: WorldModel,
    state: WorldState,
    episode: EpisodeState,
    cells: CellMap | None,
    grid: Floats,
    blocked: Bytes,
    queue: Ints,
    blocks: Flags,
    target: Floats,
    field: Floats,
    potential: Floats,
) -> None:
    """Write field, noted goal and distance [m] where the goal is new or the episode begins.

    Where the field knows no way from the agent the straight distance takes its place.
    """
    place = Grid(grid[0], grid[1], grid[2], field.shape[3], field.shape[2])
    for w in worlds:
        for a in range(agents.shape[0]):
            own = agents[a]
            x, y, goal_x, goal_y = (
                state.pose[w, own, 0],
                state.pose[w, own, 1],
                state.goal[w, own, 0],
                state.goal[w, own, 1],
            )
            if not episode.began[w, a] and goal_x == target[w, a, 0] and goal_y == target[w, a, 1]:
                continue
            target[w, a, 0], target[w, a, 1] = goal_x, goal_y
            for b in range(blocks.shape[0]):
                blocks[b] = model.present[w, b] and model.stands[b] and not model.unobstructed[b] and b != own
            obstacles, radius = Obstacles(model, state, w, blocks, cells), model.reach[row_of(model.reach, w), own]
            distance_field(obstacles, radius, (goal_x, goal_y), place, Search(blocked, field[w, a], queue))
            here = field_at(field[w, a], place, x, y)
            dx, dy = goal_x - x, goal_y - y
            potential[w, a] = here if here < np.inf else np.sqrt(dx * dx + dy * dy)


@kernel
def pay_gain(
    worlds: Ints,
    agents: Ints,
    column: int,
    weight: float,
    model: WorldModel,
    state: WorldState,
    grid: Floats,
    field: Floats,
    potential: Floats,
    out: Floats,
) -> None:
    """Write the weighted loss of distance over the diagonal of ``bounds``; nothing where the field knows no way."""
    place = Grid(grid[0], grid[1], grid[2], field.shape[3], field.shape[2])
    width, height = model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]
    rate = weight / np.sqrt(width * width + height * height)
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            here = field_at(field[w, a], place, state.pose[w, b, 0], state.pose[w, b, 1])
            here = here if here < np.inf else potential[w, a]
            out[w, a, column] = rate * (potential[w, a] - here)
            potential[w, a] = here
