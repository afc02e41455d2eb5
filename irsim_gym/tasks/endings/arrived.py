"""Arrived: the agent has reached its last goal."""

from __future__ import annotations

from typing import ClassVar

from irsim_gym.engine import Shard
from irsim_gym.scenario.options import kind
from irsim_gym.tasks.endings.body_flag import copy_flag
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.term import Term
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@kind
class Arrived:
    """End with success when the agent is within its goal threshold of the last goal."""

    only_kernels: ClassVar[bool] = True
    outcome: ClassVar[Outcome] = Outcome.SUCCESS
    needs_goal: ClassVar[bool] = True

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        return "it is within its goal_threshold of its last goal"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag."""
        copy_flag(shard.worlds, term.agents, term.column, state, episode)
