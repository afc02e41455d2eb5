"""Obstruction: the cost of being in the way of others that go first."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.paths.grid import centre
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.observations.route import Route, RouteWays, entry, find_ways
from irsim_gym.tasks.outcome import RUNNING, Outcome
from irsim_gym.tasks.term import Bound, Role, Term, forget
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@kind
class Obstruction:
    """Cost of being in the way of another learner that goes first.

    Learners that have arrived (ending ``arrived`` with ``wait``) let all others go first. Of two on their way that are
    in each other's way, the one with the higher number lets the other go first, as in the observation
    ``yielding_way``.

    The cost is ``max(0, 1 - d / width)``, times ``weight / max_steps``, where d is the distance from the first
    ``ahead`` metres of the path of the nearest learner that goes first. Paths are the shortest ones around everything
    that never moves, as in the observation ``route``.
    """

    only_kernels: ClassVar[bool] = True
    role: ClassVar[Role] = "running"
    outcome: ClassVar[Outcome] = Outcome.RUNNING
    needs_goal: ClassVar[bool] = True
    needs_ending: ClassVar[bool] = False
    after_arrival: ClassVar[bool] = True

    weight: float = option(10.0, ge=0.0, meaning="Cost of an episode spent on another's path.")
    width: float = option(0.9, gt=0.0, unit="m", meaning="Distance from the path from which the cost is zero.")
    ahead: float = option(4.0, gt=0.0, unit="m", meaning="Length of the part of the path that counts.")

    def arrays(self, simulation: Simulation, agents: Ints) -> RouteWays:
        """Return the paths, and scratch memory."""
        return Route(ahead=self.ahead, cell=None).arrays(simulation, agents)

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        most = self.weight / term.max_steps
        path = f"less than {self.width:g} m away from the next {self.ahead:g} m of another learner's path"
        return f"where others go first, at a distance d {path}: -{most:.3g} (1 - d / {self.width:g} m) a step"

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
    """Write ``amount`` times how near agents are to the paths of others that go first.

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
            for a in range(n_agents):
                is_later = episode.arrival[w, a] > 0 or a > other
                if a == other or not is_later or episode.outcome[w, a] != RUNNING:
                    continue
                far = path_distance(ways, options.ahead, w, other, b, term.agents[a], state)
                if far < options.width and episode.arrival[w, a] == 0:
                    back = path_distance(ways, options.ahead, w, a, term.agents[a], b, state)
                    far = far if back < options.width else np.inf
                cost = amount * max(0.0, 1.0 - far / options.width)
                episode.reward_term[w, a, term.column] = min(episode.reward_term[w, a, term.column], cost)


@kernel
def path_distance(ways: RouteWays, ahead: float, w: int, a: int, body: int, other: int, state: State) -> float:
    """Return the distance [m] of a body from the nearest cell centre on the first ``ahead`` metres of a path.

    It is infinite where there is no path.

    Args:
        ways: The paths.
        ahead: Length of the part [m].
        w: World.
        a: The agent whose path it is.
        body: That agent's body.
        other: The body whose distance is asked for.
        state: The state.

    Reads: ways (grid, length, onward), state (pose).
    """
    grid, onward = ways.grid, ways.onward[w, a]
    x, y = state.pose[w, other, 0], state.pose[w, other, 1]
    here, driven, best = entry(ways.length[w, a], grid, state.pose[w, body, 0], state.pose[w, body, 1]), 0.0, np.inf
    old_x, old_y = centre(grid, here // grid.columns, here % grid.columns)
    while here >= 0 and driven <= ahead:
        new_x, new_y = centre(grid, here // grid.columns, here % grid.columns)
        driven += np.sqrt((new_x - old_x) * (new_x - old_x) + (new_y - old_y) * (new_y - old_y))
        best = min(best, (new_x - x) * (new_x - x) + (new_y - y) * (new_y - y))
        old_x, old_y, here = new_x, new_y, int(onward[here])
    return float(np.sqrt(best))
