"""Deadlock: the penalty for standing still for too long."""

from typing import ClassVar

from irsim_gym.tasks.rewards.on_outcome import pay_outcome
from irsim_gym.tasks.terms import EpisodeState, Model, Role, Shard, State, Term, kind, option
from irsim_gym.tasks.terms.outcome import DEADLOCK, Outcome


@kind
class Deadlock:
    """Penalty ``-weight``, once, when the episode ends because the agent has stalled for too long."""

    role: ClassVar[Role] = "penalty"
    outcome: ClassVar[Outcome] = Outcome.DEADLOCK
    needs_goal: ClassVar[bool] = True
    needs_ending: ClassVar[bool] = True

    weight: float = option(4.0, ge=0.0, meaning="Penalty for a deadlock.")

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"-{self.weight:g}, once, when the episode ends in a deadlock"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the penalty."""
        pay_outcome(shard.worlds, term.column, DEADLOCK, -term.options.weight, episode)
