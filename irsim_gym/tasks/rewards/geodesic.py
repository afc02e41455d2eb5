"""Geodesic distances to the goal for rewards, around everything that never moves: one field per agent and world."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Cells, Flags, Floats, Ints
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.paths.geodesic import distance_field, field_at
from irsim_gym.simulator.paths.grid import Grid, Search
from irsim_gym.tasks.terms import Bound, EpisodeState, Model, Shard, Simulation, State, Struct, Term, kernel, row_of
from irsim_gym.tasks.terms.scaling import diagonal


@dataclass
class Fields(Struct):
    """Distances to the agents' goals on a grid, and scratch memory for computing them.

    Attributes:
        grid: The grid.
        target: The goals [m], shape ``(n_worlds, n_agents, 2)``.
        potential: Each agent's distance one step ago [m], shape ``(n_worlds, n_agents)``.
        field: The distances [m], shape ``(n_worlds, n_agents, rows, columns)``.
        blocked: Scratch, see ``Search``; as in all following arrays, the first axis is the slot.
        queue: Scratch, see ``Search``.
        blocks: Scratch: flags of bodies that are obstacles, shape ``(n_slots, n_bodies)``.
    """

    grid: Grid
    target: Floats
    potential: Floats
    field: Floats
    blocked: Bytes
    queue: Ints
    blocks: Flags

    @classmethod
    def over(cls, simulation: Simulation, n_agents: int, cell: float) -> Self:
        """Return fields with a cell size [m]."""
        grid = Grid.over(simulation.model.bounds, cell)
        search = grid.search()
        slots, shape = simulation.shards.n_slots, (simulation.n_worlds, n_agents)
        return cls(
            grid=grid,
            target=np.zeros((*shape, 2)),
            potential=np.zeros(shape),
            field=np.full((*shape, grid.rows, grid.columns), np.inf),
            blocked=np.stack([search.blocked] * slots),
            queue=np.stack([search.queue] * slots),
            blocks=np.zeros((slots, len(simulation.scenario.bodies)), np.bool_),
        )


def note_fields(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
    """Compute the fields of agents whose episode begins or whose goal has changed, and store goals and distances."""
    worlds, slot = shard.worlds, shard.slot
    draw_fields(worlds, slot, term.agents, term.arrays, model, model.cells, state, episode)


@kernel
def draw_fields(
    worlds: Ints,
    slot: int,
    agents: Ints,
    fields: Fields,
    model: Model,
    cells: Cells,
    state: State,
    episode: EpisodeState,
) -> None:
    """Write field, goal and distance [m] if the goal is new or the episode begins.

    If the field has no path from the agent, the straight distance is used.

    Reads: fields (blocked, blocks, field, grid, queue, target), model (present, reach, stands, unobstructed), state
        (goal, pose), episode (began).
    Writes: fields (blocks, potential, target).
    """
    grid, blocked, queue, blocks = fields.grid, fields.blocked[slot], fields.queue[slot], fields.blocks[slot]
    for w in worlds:
        for a in range(agents.shape[0]):
            body, target, field = agents[a], fields.target[w, a], fields.field[w, a]
            x, y = state.pose[w, body, 0], state.pose[w, body, 1]
            goal_x, goal_y = state.goal[w, body, 0], state.goal[w, body, 1]
            if not episode.began[w, a] and goal_x == target[0] and goal_y == target[1]:
                continue
            target[0], target[1] = goal_x, goal_y
            mark_standing(model, w, body, blocks)
            obstacles = Obstacles(model, state, w, blocks, cells, None)
            radius = model.reach[row_of(model.reach, w), body]
            distance_field(obstacles, radius, (goal_x, goal_y), grid, Search(blocked, field, queue))
            distance = field_at(field, grid, x, y)
            dx, dy = goal_x - x, goal_y - y
            fields.potential[w, a] = distance if distance < np.inf else np.sqrt(dx * dx + dy * dy)


@kernel
def pay_field_gain(
    worlds: Ints, term: Bound, fields: Fields, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the weighted decrease of distance over the diagonal of ``bounds``; 0 if the field has no path.

    Reads: term (agents, column, options), fields (field, grid, potential), model (bounds), state (pose).
    Writes: fields (potential), episode (reward_term).
    """
    grid, potential = fields.grid, fields.potential
    rate = term.options[0].weight / diagonal(model.bounds)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b = term.agents[a]
            distance = field_at(fields.field[w, a], grid, state.pose[w, b, 0], state.pose[w, b, 1])
            # Without a path from here, nothing is gained or lost in this step.
            distance = distance if distance < np.inf else potential[w, a]
            episode.reward_term[w, a, term.column] = rate * (potential[w, a] - distance)
            potential[w, a] = distance
