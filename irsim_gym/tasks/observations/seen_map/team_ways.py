"""The ways of a team's learners, over maps without robots: what robots that tell each other their ways know."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from irsim_gym.simulator.cell_paths.scan_marks import beam_end, eye_of
from irsim_gym.simulator.geometry.angles import turned
from irsim_gym.simulator.paths.grid import Grid, centre
from irsim_gym.simulator.world.names import Bytes, Flags, Floats, Ints, Labels, Point
from irsim_gym.tasks.observations.seen_map.seen_grid import SeenGrid
from irsim_gym.tasks.observations.seen_map.seen_ways import SeenWays, way_ahead
from irsim_gym.tasks.observations.seen_map.way_columns import write_way
from irsim_gym.tasks.terms import RUNNING, Bound, EpisodeState, Model, Simulation, State, Struct, kernel, row_of
from irsim_gym.tasks.terms.scaling import diagonal

MARGIN = 0.1
"""Hits up to this distance outside the disc around a robot are hits of the robot [m]."""


@dataclass
class TeamWays(Struct):
    """The agents' ways to their goals over maps without robots, and who yields to whom.

    Attributes:
        ways: The maps, and the costs of ways over them.
        robots: Bodies whose hits are left out of the maps, shape ``(n_robots,)``.
        points: First points of each agent's way, from the agent on [m], shape ``(n_worlds, n_agents, n_points, 2)``.
        count: Number of these points; 0 without a way, after an arrival and after the end, shape ``(n_worlds,
            n_agents)``.
        yields: Whether an agent (second axis) yields to another (third axis), shape ``(n_worlds, n_agents,
            n_agents)``.
        is_stuck: Whether an agent should stand aside and cannot, shape ``(n_worlds, n_agents)``.
        levels: Scratch: cells in which a learner fits beside the robots, shape ``(n_slots, rows, columns)``.
        costs: Scratch: costs of ways over these cells, shaped alike.
        width: Distance that robots need from the ways of others [m].
    """

    ways: SeenWays
    robots: Ints
    points: Floats
    count: Labels
    yields: Flags
    is_stuck: Flags
    levels: Bytes
    costs: Labels
    width: float

    @classmethod
    def over(cls, term: Any, simulation: Simulation, agents: Ints, name: str) -> Self:
        """Return empty maps without ways.

        Args:
            term: An observation with the attributes ``cell``, ``every``, ``ahead``, ``width`` and ``without_sensor``.
            simulation: The simulation.
            agents: Body indices of the learners, shape ``(n_agents,)``.
            name: The observation's name, for errors.
        """
        seen = SeenGrid.over(term, simulation, agents, name, follows=False)
        shape, slots = (simulation.n_worlds, len(agents)), simulation.shards.n_slots
        cells = slots, seen.grid.rows, seen.grid.columns
        seen.skipped = np.zeros((*shape, seen.scan.ranges.shape[2]), np.bool_)
        return cls(
            ways=SeenWays.over(seen, slots, 0.0),
            robots=np.array(simulation.scenario.robots, np.int64),
            points=np.zeros((*shape, int(term.ahead / seen.grid.cell) + 2, 2)),
            count=np.zeros(shape, np.int32),
            yields=np.zeros((*shape, len(agents)), np.bool_),
            is_stuck=np.zeros(shape, np.bool_),
            levels=np.zeros(cells, np.uint8),
            costs=np.zeros(cells, np.int32),
            width=term.width,
        )


@kernel
def skip_robots(worlds: Ints, term: Bound, team: TeamWays, model: Model, state: State, episode: EpisodeState) -> None:
    """Flag the beams that hit a robot, in scans that are about to be added to a map.

    Reads: term (agents), team (robots, ways), model (present, reach), state (pose), episode (steps).
    Writes: team (ways).
    """
    seen = team.ways.seen
    scan, grid = seen.scan, seen.grid
    for w in worlds:
        reach = model.reach[row_of(model.reach, w)]
        for a in range(term.agents.shape[0]):
            if episode.steps[w, a] % seen.every != 0:
                continue
            body = term.agents[a]
            eye, readings = eye_of(scan, a, state.pose[w, body], grid), scan.ranges[w, scan.sensors[a]]
            for i in range(readings.shape[0]):
                x, y = beam_end(scan, eye, scan.sensors[a], i, float(readings[i]))
                skipped = False
                for b in team.robots:
                    dx = grid.origin_x + x * grid.cell - state.pose[w, b, 0]
                    dy = grid.origin_y + y * grid.cell - state.pose[w, b, 1]
                    far = reach[b] + MARGIN
                    skipped = skipped or (b != body and model.present[w, b] and dx * dx + dy * dy < far * far)
                seen.skipped[w, a, i] = skipped


@kernel
def write_own_ways(
    worlds: Ints, slot: int, term: Bound, team: TeamWays, model: Model, state: State, episode: EpisodeState
) -> None:
    """Find the ways to the goals of agents that have not arrived, and write their three elements and first points.

    Reads: term (agents, column), team (ways), model (bounds), state (direction, goal, pose), episode (arrival,
        outcome).
    Writes: team (count, points, ways), episode (observation).
    """
    full = diagonal(model.bounds)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            team.count[w, a] = 0
            if episode.arrival[w, a] > 0:
                continue
            b = term.agents[a]
            place, goal = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            there, rest, n_cells = way_ahead(team.ways, slot, w, a, place, goal)
            row = episode.observation[w, a, term.column : term.column + 3]
            write_way(row, place, turned(state.pose[w, b, 2], state.direction[w, b]), there, rest, full)
            if episode.outcome[w, a] == RUNNING and rest < np.inf:
                way, grid = team.ways.way[slot, :n_cells], team.ways.seen.grid
                team.count[w, a] = write_points(team.points[w, a], place, goal, way, grid)


@kernel
def write_points(points: Floats, place: Point, goal: Point, way: Labels, grid: Grid) -> int:
    """Write the first points of a way [m], one for each cell, and return their number.

    Args:
        points: The points, as many as there is room for, shape ``(n_points, 2)``.
        place: The first point [m].
        goal: Where the way leads [m].
        way: Numbers of its cells; none if it is straight, shape ``(n_cells,)``.
        grid: The grid of the cells.

    Writes: points.
    """
    dx, dy = goal[0] - place[0], goal[1] - place[1]
    cells = np.sqrt(dx * dx + dy * dy) / grid.cell
    count = min(points.shape[0], (int(cells) if way.shape[0] == 0 else way.shape[0]) + 1)
    points[0, 0], points[0, 1] = place
    for k in range(1, count):
        if way.shape[0] == 0:
            points[k, 0], points[k, 1] = place[0] + dx * k / cells, place[1] + dy * k / cells
        else:
            points[k, 0], points[k, 1] = centre(grid, way[k - 1] // grid.columns, way[k - 1] % grid.columns)
    return int(count)
