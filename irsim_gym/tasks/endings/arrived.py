"""Arrived: the agent has reached its last goal."""

from __future__ import annotations

from typing import ClassVar

from irsim_gym.arraytypes import Ints
from irsim_gym.engine import Shard
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.endings.body_flag import copy_flag
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.term import Term
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@kind
class Arrived:
    """End with success when the agent is within its goal threshold of the last goal.

    With ``wait``, the agent succeeds there, but its episode goes on, so that it can make way for others. It ends when
    no agent of the world is on its way any more, at the time limit, or by a failure, whose penalty is paid, but which
    does not undo the success. After its arrival, the agent gets no progress and has no running costs, and its path and
    its time do not grow.
    """

    only_kernels: ClassVar[bool] = True
    outcome: ClassVar[Outcome] = Outcome.SUCCESS
    needs_goal: ClassVar[bool] = True

    wait: bool = option(False, meaning="Whether the agent drives on until the whole team has arrived or failed.")

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        there = "within its goal_threshold of its last goal"
        return f"it has been {there}, and no agent is on its way any more" if self.wait else f"it is {there}"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag."""
        if term.options.wait:
            wait_for_team(shard.worlds, term.agents, term.column, term.max_steps, state, episode)
        else:
            copy_flag(shard.worlds, term.agents, term.column, state, episode)


@kernel
def wait_for_team(worlds: Ints, agents: Ints, column: int, max_steps: int, state: State, episode: EpisodeState) -> None:
    """Note arrivals, and flag the agents that have arrived if no agent is on its way, or at the time limit.

    Reads: state (arrived), episode (arrival, ending, over, steps).
    Writes: episode (arrival, ending).
    """
    for w in worlds:
        is_on_its_way = False
        for a in range(agents.shape[0]):
            if episode.over[w, a]:
                continue
            if episode.arrival[w, a] == 0 and state.arrived[w, agents[a]]:
                episode.arrival[w, a] = episode.steps[w, a]
            fails = False
            for k in range(column):  # endings of higher precedence, already written
                fails = fails or episode.ending[w, a, k]
            if episode.arrival[w, a] == 0 and not fails and episode.steps[w, a] < max_steps:
                is_on_its_way = True
        for a in range(agents.shape[0]):
            has_time = is_on_its_way and episode.steps[w, a] < max_steps
            episode.ending[w, a, column] = episode.arrival[w, a] > 0 and not has_time
