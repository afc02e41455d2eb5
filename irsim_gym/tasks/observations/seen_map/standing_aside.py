"""Standing aside: which robots of a team yield to which, and where they go to let them pass."""

import numpy as np

from irsim_gym.simulator.cell_paths.cell_lines import free_cell
from irsim_gym.simulator.cell_paths.wavefront import (
    STRAIGHT,
    begin_costs,
    begin_wave,
    follow_costs,
    next_cell,
    offer_neighbours,
    spread_costs,
)
from irsim_gym.simulator.geometry.angles import turned
from irsim_gym.simulator.paths.grid import BLOCKED, Grid, centre
from irsim_gym.simulator.world.names import Bytes, Floats, Ints, Point
from irsim_gym.tasks.observations.seen_map.seen_ways import last_in_sight
from irsim_gym.tasks.observations.seen_map.team_ways import TeamWays
from irsim_gym.tasks.observations.seen_map.way_columns import write_way
from irsim_gym.tasks.terms import Bound, EpisodeState, Model, State, diagonal, kernel, row_of

SOON = 1.5
"""Two agents on their way meet if the first of them comes upon the other's way within this length of its own [m]."""


@kernel
def write_asides(
    worlds: Ints, slot: int, term: Bound, team: TeamWays, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the three elements of agents that yield or have arrived: where to go, or to stay.

    Agents with higher numbers come first, as those with lower ones yield to them only if they cannot stand aside.

    Reads: term (agents, column), team (costs, count, is_stuck, levels, points, robots, ways, width, yields), model
        (bounds, present, reach), state (direction, pose), episode (arrival).
    Writes: team (costs, is_stuck, levels, ways, yields), episode (observation).
    """
    n_agents, full = term.agents.shape[0], diagonal(model.bounds)
    for w in worlds:
        for a in range(n_agents):
            team.is_stuck[w, a] = False
        for a in range(n_agents - 1, -1, -1):
            find_yields(team, w, a, term, state, episode)
            if episode.arrival[w, a] == 0 and not yields_to_any(team, w, a):
                continue
            b = term.agents[a]
            place, rest = (state.pose[w, b, 0], state.pose[w, b, 1]), 0.0
            there = place
            if is_in_way(team, w, a, place):
                there, rest = find_aside(team, slot, w, a, b, model, state)
                team.is_stuck[w, a] = rest == np.inf
                if rest == np.inf and episode.arrival[w, a] == 0:
                    continue
            row = episode.observation[w, a, term.column : term.column + 3]
            write_way(row, place, turned(state.pose[w, b, 2], state.direction[w, b]), there, rest, full)


@kernel
def find_yields(team: TeamWays, w: int, a: int, term: Bound, state: State, episode: EpisodeState) -> None:
    """Flag the agents to which an agent yields.

    Reads: team (count, is_stuck, points, ways, width), term (agents), state (pose), episode (arrival).
    Writes: team (yields).
    """
    way = team.points[w, a, : team.count[w, a]]
    soon = way[: int(SOON / team.ways.seen.grid.cell) + 1]
    for other in range(term.agents.shape[0]):
        points, b = team.points[w, other, : team.count[w, other]], term.agents[other]
        team.yields[w, a, other] = other != a and (
            episode.arrival[w, a] > 0
            or (
                (other < a or team.is_stuck[w, other])
                and is_beside(way, (state.pose[w, b, 0], state.pose[w, b, 1]), team.width)
                and come_near(soon, points, team.width)
            )
        )


@kernel
def yields_to_any(team: TeamWays, w: int, a: int) -> bool:
    """Return whether an agent yields to any other.

    Reads: team (yields).
    """
    return bool(team.yields[w, a].any())


@kernel
def is_beside(points: Floats, place: Point, width: float) -> bool:
    """Return whether a point [m] is within ``width`` of one of the points of a way, shape ``(n, 2)``."""
    for k in range(points.shape[0]):
        dx, dy = points[k, 0] - place[0], points[k, 1] - place[1]
        if dx * dx + dy * dy < width * width:
            return True
    return False


@kernel
def come_near(ones: Floats, others: Floats, width: float) -> bool:
    """Return whether any of some points is within ``width`` of any of others [m], shapes ``(n, 2)``."""
    near = False
    for k in range(ones.shape[0]):
        near = near or is_beside(others, (ones[k, 0], ones[k, 1]), width)
    return near


@kernel
def is_in_way(team: TeamWays, w: int, a: int, place: Point) -> bool:
    """Return whether a point [m] is within ``width`` of the way of an agent to which another yields.

    Reads: team (count, points, width, yields).
    """
    for other in range(team.count.shape[1]):
        if team.yields[w, a, other] and is_beside(team.points[w, other, : team.count[w, other]], place, team.width):
            return True
    return False


@kernel
def find_aside(team: TeamWays, slot: int, w: int, a: int, b: int, model: Model, state: State) -> tuple[Point, float]:
    """Find the nearest place out of the way of the others.

    Reads: team (costs, count, levels, points, robots, ways, width, yields), model (present, reach), state (pose).
    Writes: team (costs, levels, ways).

    Returns:
        The last point of the path there that can be reached straight [m], and the length of the rest of the path [m];
        infinite if there is no such place.
    """
    ways, levels, costs = team.ways, team.levels[slot], team.costs[slot]
    grid, way = ways.seen.grid, ways.way[slot]
    here, reach = (state.pose[w, b, 0], state.pose[w, b, 1]), model.reach[row_of(model.reach, w)]
    for i in range(grid.rows):
        for j in range(grid.columns):
            levels[i, j] = ways.levels[w, a, i, j]
    for other in team.robots:
        if other != b and model.present[w, other]:
            place = (state.pose[w, other, 0], state.pose[w, other, 1])
            block_disc(grid, place, reach[other] + reach[b], levels)
    start = free_cell(grid, levels, here)
    if start < 0:
        return here, np.inf
    end = nearest_outside(team, slot, w, a, start)
    if end < 0:
        return here, np.inf
    begin_costs(end, costs)
    count = follow_costs(levels, costs, start, way)
    if count == 0:
        spread_costs(levels, end, ways.queues[slot], costs)
        count = follow_costs(levels, costs, start, way)
    if count == 0:
        return here, np.inf
    last = last_in_sight(here, grid, levels, way, count)
    return centre(grid, last // grid.columns, last % grid.columns), costs.reshape(-1)[last] * (grid.cell / STRAIGHT)


@kernel
def nearest_outside(team: TeamWays, slot: int, w: int, a: int, start: int) -> int:
    """Return the number of the cell nearest to a cell that is not in the way of others, -1 if there is none.

    The way from there to the start counts. Of several equally near cells it is the one with the lowest number.

    Reads: team (costs, count, levels, points, ways, width, yields).
    Writes: team (ways).
    """
    grid, queues = team.ways.seen.grid, team.ways.queues[slot]
    walls, costs = team.levels[slot].reshape(-1), team.costs[slot].reshape(-1)
    begin_wave(start, queues, costs)
    cell, here = -1, next_cell(queues, costs)
    while here >= 0 and (cell < 0 or costs[here] == costs[cell]):
        if not is_in_way(team, w, a, centre(grid, here // grid.columns, here % grid.columns)):
            cell = here if cell < 0 else min(cell, here)
        offer_neighbours(walls, grid.columns, here, queues, costs)
        here = next_cell(queues, costs)
    return cell


@kernel
def block_disc(grid: Grid, place: Point, radius: float, levels: Bytes) -> None:
    """Block the cells whose centres are within a radius [m] of a point [m].

    Writes: levels.
    """
    column, row = (place[0] - grid.origin_x) / grid.cell, (place[1] - grid.origin_y) / grid.cell
    reach = radius / grid.cell
    for i in range(max(int(row - reach), 0), min(int(row + reach) + 2, grid.rows)):
        for j in range(max(int(column - reach), 0), min(int(column + reach) + 2, grid.columns)):
            dx, dy = j + 0.5 - column, i + 0.5 - row
            if dx * dx + dy * dy < reach * reach:
                levels[i, j] = BLOCKED
