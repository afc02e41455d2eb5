"""Distances to the goal around what never moves, for rewards: one field for each agent of each world."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Bytes, CellMap, Flags, Floats, Ints
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.paths.geodesic import distance_field, field_at
from irsim_gym.paths.grid import Grid
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Term
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


def field_arrays(simulation: Simulation, n_agents: int, cell: float) -> dict[str, NDArray[Any]]:
    """Return the fields, ``(n_worlds, n_agents, rows, columns)`` [m], their grid, and scratch for each shard."""
    grid = Grid.over(simulation.model.bounds, cell)
    slots, n_bodies = simulation.shards.n_slots, len(simulation.scenario.bodies)
    shape = (simulation.n_worlds, n_agents, grid.rows, grid.columns)
    return {
        "grid": np.array([grid.origin_x, grid.origin_y, grid.cell]),
        "field": np.full(shape, np.inf),
        "blocked": np.stack([grid.blocked() for _ in range(slots)]),
        "queue": np.stack([grid.queue() for _ in range(slots)]),
        "blocks": np.zeros((slots, n_bodies), np.bool_),
    }


def note_fields(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
    """Draw the fields of agents whose episode begins or whose goal has changed, and note goals and distances."""
    table, slot = term.arrays, shard.slot
    draw_fields(
        shard.worlds,
        term.agents,
        episode.began,
        model.present,
        model.stands,
        model.unobstructed,
        model.reach,
        state.segments,
        model.segment_start,
        model.segment_count,
        state.discs,
        model.disc_start,
        model.disc_count,
        model.solid,
        model.cells,
        state.pose,
        state.goal,
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
        model.bounds,
        state.pose,
        table["grid"],
        table["field"],
        table["potential"],
        out,
    )


@kernel
def draw_fields(
    worlds: Ints,
    agents: Ints,
    began: Flags,
    present: Flags,
    stands: Flags,
    unobstructed: Flags,
    reach: Floats,
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    cells: CellMap | None,
    pose: Floats,
    goal: Floats,
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
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            own = agents[a]
            x, y, goal_x, goal_y = pose[w, own, 0], pose[w, own, 1], goal[w, own, 0], goal[w, own, 1]
            if not began[w, a] and goal_x == target[w, a, 0] and goal_y == target[w, a, 1]:
                continue
            target[w, a, 0], target[w, a, 1] = goal_x, goal_y
            for b in range(blocks.shape[0]):
                blocks[b] = present[w, b] and stands[b] and not unobstructed[b] and b != own
            distance_field(
                segments[w],
                segment_start,
                segment_count[w % segment_count.shape[0]],
                discs[w],
                disc_start,
                disc_count[w % disc_count.shape[0]],
                solid,
                blocks,
                cells,
                reach[w % reach.shape[0], own],
                goal_x,
                goal_y,
                grid[0],
                grid[1],
                grid[2],
                blocked,
                field[w, a],
                queue,
            )
            here = field_at(field[w, a], grid[0], grid[1], grid[2], x, y)
            dx, dy = goal_x - x, goal_y - y
            potential[w, a] = here if here < np.inf else np.sqrt(dx * dx + dy * dy)


@kernel
def pay_gain(
    worlds: Ints,
    agents: Ints,
    column: int,
    weight: float,
    bounds: Floats,
    pose: Floats,
    grid: Floats,
    field: Floats,
    potential: Floats,
    out: Floats,
) -> None:
    """Write the weighted loss of distance over the diagonal of ``bounds``; nothing where the field knows no way."""
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    rate = weight / np.sqrt(width * width + height * height)
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            b = agents[a]
            here = field_at(field[w, a], grid[0], grid[1], grid[2], pose[w, b, 0], pose[w, b, 1])
            here = here if here < np.inf else potential[w, a]
            out[w, a, column] = rate * (potential[w, a] - here)
            potential[w, a] = here
