"""Yielding way: the way to the goal of a robot that knows the ways of its team, or out of the way of others."""

from typing import ClassVar

from irsim_gym.simulator.world.names import Ints, Model, Shard, State, kind, option
from irsim_gym.tasks.observations.scan.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.seen_map.seen_grid import CELL, EVERY, forget_seen, note_all
from irsim_gym.tasks.observations.seen_map.seen_ways import clear_levels, narrow_ways
from irsim_gym.tasks.observations.seen_map.standing_aside import write_asides
from irsim_gym.tasks.observations.seen_map.team_ways import TeamWays, skip_robots, write_own_ways
from irsim_gym.tasks.observations.seen_map.way_columns import ObservesWay, way_columns
from irsim_gym.tasks.terms import Columns, EpisodeState, Needs, Simulation, Term, diagonal


@kind
class YieldingWay(ObservesWay):
    """Direction and length of the way that the agent should take, if the robots of a team tell each other their ways.

    On its way it is the shortest one to the next goal on the map from the agent's own scans, as in
    ``way_on_seen_map``, but without robots: hits of robots, whose places are known to each other, are left out. An
    agent that yields and that stands within ``width`` of the next ``ahead`` metres of the others' ways is led to the
    nearest place that does not, past the robots in their present places. An agent that yields elsewhere, or has
    arrived, is told to stay: straight ahead, length 0. Without such a place, an agent that has arrived observes length
    1, and another its way to the goal.

    Agents that have arrived yield to all that are on their way. Of two on their way that meet, the one with the higher
    number yields, or the other if that one cannot stand aside. They meet if the other stands within ``width`` of the
    next ``ahead`` metres of the agent's way, and the next 1.5 m of it come within ``width`` of the other's. These two
    lengths are counted in cells: along the diagonals of the grid they are up to 1.4 times as long.
    """

    needs: ClassVar[Needs] = ("scan", "odometry", "grid", "messages")

    cell: float | None = CELL
    every: int = EVERY
    ahead: float = option(4.0, gt=0.0, unit="m", meaning="Length of the part of the ways that others know.")
    width: float = option(0.8, gt=0.0, unit="m", meaning="Distance that robots need from the ways of others.")
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def arrays(self, simulation: Simulation, agents: Ints) -> TeamWays:
        """Return the maps, the ways, and scratch memory."""
        return TeamWays.over(self, simulation, agents, "yielding_way")

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        point = "of the direction of its way, to the goal as if there were no robots or out of the ways of others"
        scaled = f"s / {diagonal(model.bounds):.3g} m, at most 1; 1 where there is none; 0 to stay"
        return way_columns(point, "length s of that way", scaled)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the maps and ways."""
        ways = term.arrays.ways
        forget_seen(shard.worlds, ways.seen, episode)
        clear_levels(shard.worlds, ways, episode)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Add the latest scans to the maps, find the ways, and write the three elements."""
        team = term.arrays
        ways = team.ways
        skip_robots(shard.worlds, term.bound, team, model, state, episode)
        note_all(shard.worlds, shard.slot, term.bound, ways.seen, state, episode)
        narrow_ways(shard.worlds, term.bound, ways, model, episode)
        write_own_ways(shard.worlds, shard.slot, term.bound, team, model, state, episode)
        write_asides(shard.worlds, shard.slot, term.bound, team, model, state, episode)
