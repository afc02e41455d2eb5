"""Way on the seen map: the shortest path to the goal on the map from the learner's own scans."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.simulator.geometry.angles import turned
from irsim_gym.tasks.observations.scan.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.seen_map.seen_grid import EVERY, SeenGrid, forget_seen, note_all, shared_map
from irsim_gym.tasks.observations.seen_map.seen_ways import SeenWays, clear_levels, narrow_ways, way_ahead
from irsim_gym.tasks.observations.seen_map.way_columns import ObservesWay, way_columns, write_way
from irsim_gym.tasks.terms import Columns, EpisodeState, Model, Shard, Simulation, State, kernel, kind, option
from irsim_gym.tasks.terms.graph import RobotValues, Value
from irsim_gym.tasks.terms.scaling import diagonal
from irsim_gym.tasks.terms.term import Bound, Needs, Term


@kind
class WayOnSeenMap(ObservesWay):
    """Direction and length of the shortest path to the next goal on the map from the agent's own scans.

    Unknown space counts as free (Koenig and Smirnov 1996). The direction, as cosine and sine, is that of the last point
    of the path that can be reached straight. The length is divided by the world's diagonal and clipped to 1. Cells in
    which the agent fits, but not at their centre, cost eight times as much. Without a path, the direction is that of
    the goal, and the length is 1. If other bodies can move, a beam clears earlier hits as far as the beams beside it
    reach, too.
    """

    needs: ClassVar[Needs] = ("scan", "odometry", "grid")

    cell: float | None = option(
        None,
        gt=0.0,
        unit="m",
        meaning="Cell size; default: a 64th of the world's longer side.",
        consequence="Cells wider than the agent close gaps that it fits through.",
    )
    every: int = EVERY
    clearance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Distance that the path keeps from obstacles.",
        consequence="The way leads through gaps that the agent fits through by millimetres.",
    )
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def arrays(self, simulation: Simulation, agents: Ints) -> SeenWays:
        """Return the maps, the paths, and scratch memory."""
        seen = SeenGrid.over(self, simulation, agents, "way_on_seen_map", follows=False)
        return SeenWays.over(seen, simulation.shards.n_slots, self.clearance)

    def join(self, term: Term, earlier: Sequence[Term]) -> None:
        """Share the map of an earlier observation, if possible."""
        term.arrays.seen = shared_map(term.arrays.seen, earlier)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns."""
        point = "of the direction of the shortest way to the next goal on what its scans have shown"
        scaled = f"s / {diagonal(model.bounds):.3g} m, at most 1; 1 where there is none"
        return way_columns(point, "length s of that way", scaled)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph, see ``HasGraph``; the robot finds the way itself (``parts/perceive.py``)."""
        way = robot.graph.input("way_on_seen_map", np.float64, 3)
        first = robot.ways(way.columns(0, 2).spread(1))
        length = ((first.length(2) + way.columns(2, 3)) / diagonal(model.bounds)).least(1.0)
        return robot.graph.join([robot.direction(first), length]).cast(np.float32)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the maps and paths."""
        ways = term.arrays
        forget_seen(shard.worlds, ways.seen, episode)
        clear_levels(shard.worlds, ways, episode)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Add the latest scans to the maps, and write the three elements."""
        measured = term.measured or state
        note_all(shard.worlds, shard.slot, term.bound, term.arrays.seen, measured, episode)
        narrow_ways(shard.worlds, term.bound, term.arrays, model, episode)
        write_ways_seen(shard.worlds, shard.slot, term.bound, term.arrays, model, measured, state, episode)


@kernel
def write_ways_seen(
    worlds: Ints, slot: int, term: Bound, ways: SeenWays, model: Model, state: State, seen: State, episode: EpisodeState
) -> None:
    """Write cosine and sine of the path's direction, (1, 0) at the goal itself, and its length over the diagonal.

    The path begins where the agent is, its direction and length where it is seen from.

    Reads: term (agents, column), ways (least, levels, queues, seen, target, way), model (bounds), state (goal, pose),
        seen (direction, pose).
    Writes: ways (least, queues, target, way), episode (observation).
    """
    full = diagonal(model.bounds)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b = term.agents[a]
            here, goal = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            there, rest, _ = way_ahead(ways, slot, w, a, here, goal)
            row = episode.observation[w, a, term.column : term.column + 3]
            eye = seen.pose[w, b, 0], seen.pose[w, b, 1]
            write_way(row, eye, turned(seen.pose[w, b, 2], seen.direction[w, b]), there, rest, full)
