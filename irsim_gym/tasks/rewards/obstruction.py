"""Obstruction: the cost of standing in the way of others after an arrival."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.paths.grid import Grid, centre
from irsim_gym.simulator.world.names import Ints, Model, Shard, Spans, State, kernel, kind, option
from irsim_gym.tasks.observations.goal.route import Route, RouteWays, entry, find_ways
from irsim_gym.tasks.terms import RUNNING, Bound, EpisodeState, RewardDefaults, Simulation, Term, forget


@kind
class Obstruction(RewardDefaults):
    """Cost of being in the way of another learner after an arrival (ending ``arrived`` with ``wait``).

    It is ``max(0, 1 - d / width)``, times ``weight / max_steps``, where d is the distance from the first ``ahead``
    metres of the shortest path of the learner on its way that is nearest. Paths avoid everything that never moves, as
    in the observation ``route``.
    """

    needs_goal: ClassVar[bool] = True
    after_arrival: ClassVar[bool] = True

    # With 10, one of three trainings in jaxnav_four ended with robots that stand still in the way of others.
    weight: float = option(30.0, ge=0.0, meaning="Cost of an episode spent on another's path.")
    width: float = option(0.9, gt=0.0, unit="m", meaning="Distance from the path from which the cost is zero.")
    ahead: float = option(4.0, gt=0.0, unit="m", meaning="Length of the part of the path that counts.")

    def arrays(self, simulation: Simulation, agents: Ints) -> RouteWays:
        """Return the paths, and scratch memory."""
        return Route(ahead=self.ahead, cell=None).arrays(simulation, agents)

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        most = self.weight / term.max_steps
        path = f"less than {self.width:g} m away from the next {self.ahead:g} m of another learner's path"
        return f"after an arrival, at a distance d {path}: -{most:.3g} (1 - d / {self.width:g} m) a step"

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the goals, so that all paths are computed again."""
        forget(term.arrays.target, np.nan, episode, shard)

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Compute the paths to new goals, and write the cost."""
        find_ways(shard.worlds, shard.slot, term.agents, term.arrays, model, model.cells, state)
        amount = -term.options.weight / term.max_steps
        pay_obstruction(shard.worlds, term.bound, amount, term.arrays, state, episode)


@kernel
def pay_obstruction(
    worlds: Ints, term: Bound, amount: float, ways: RouteWays, state: State, episode: EpisodeState
) -> None:
    """Write ``amount`` times how near agents that have arrived are to the paths of agents on their way.

    Reads: term (agents, column, options), ways (grid, length, onward), state (pose), episode (arrival, outcome,
        reward_term).
    Writes: episode (reward_term).
    """
    options, n_agents = term.options[0], term.agents.shape[0]
    for w in worlds:
        episode.reward_term[w, :, term.column] = 0.0
        for other in range(n_agents):
            b = term.agents[other]
            if episode.arrival[w, other] > 0 or episode.outcome[w, other] != RUNNING:
                continue
            first = entry(ways.length[w, other], ways.grid, state.pose[w, b, 0], state.pose[w, b, 1])
            for a in range(n_agents if first >= 0 else 0):
                if a == other or episode.arrival[w, a] == 0 or episode.outcome[w, a] != RUNNING:
                    continue
                x, y = state.pose[w, term.agents[a], 0], state.pose[w, term.agents[a], 1]
                far = path_distance(ways.onward[w, other], ways.grid, first, options.ahead, x, y)
                cost = amount * max(0.0, 1.0 - far / options.width)
                episode.reward_term[w, a, term.column] = min(episode.reward_term[w, a, term.column], cost)


@kernel
def path_distance(onward: Spans, grid: Grid, first: int, ahead: float, x: float, y: float) -> float:
    """Return the distance [m] of a point from the nearest cell centre on the first ``ahead`` metres of a path.

    Args:
        onward: Number of the next cell on the path, -1 at its end, shape ``(n_cells,)``.
        grid: The grid.
        first: Number of the first cell.
        ahead: Length of the part [m].
        x: The point [m].
        y: The point [m].
    """
    cell, driven, best = first, 0.0, np.inf
    old_x, old_y = centre(grid, cell // grid.columns, cell % grid.columns)
    while cell >= 0 and driven <= ahead:
        new_x, new_y = centre(grid, cell // grid.columns, cell % grid.columns)
        driven += np.sqrt((new_x - old_x) * (new_x - old_x) + (new_y - old_y) * (new_y - old_y))
        best = min(best, (new_x - x) * (new_x - x) + (new_y - y) * (new_y - y))
        old_x, old_y, cell = new_x, new_y, int(onward[cell])
    return float(np.sqrt(best))
