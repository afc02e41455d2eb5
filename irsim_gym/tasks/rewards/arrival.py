"""Arrival: the bonus for success."""

from __future__ import annotations

from typing import ClassVar

from irsim_gym.engine import Shard
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.outcome import SUCCESS, Outcome
from irsim_gym.tasks.rewards.on_outcome import pay_outcome
from irsim_gym.tasks.term import Role, Term
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@kind
class Arrival:
    """Bonus ``+weight``, once, when the episode ends with success."""

    only_kernels: ClassVar[bool] = True
    role: ClassVar[Role] = "bonus"
    outcome: ClassVar[Outcome] = Outcome.SUCCESS
    needs_goal: ClassVar[bool] = True
    needs_ending: ClassVar[bool] = True

    weight: float = option(5.0, ge=0.0, meaning="Bonus for success.")

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"+{self.weight:g}, once, when the episode ends with success"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the bonus."""
        pay_outcome(shard.worlds, term.column, SUCCESS, term.options.weight, episode)
