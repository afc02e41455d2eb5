"""Left the world: the penalty for leaving the world's rectangle."""

from typing import ClassVar

from irsim_gym.tasks.rewards.on_outcome import pay_outcome
from irsim_gym.tasks.terms import EpisodeState, Model, RewardDefaults, Role, Shard, State, Term, kind, option
from irsim_gym.tasks.terms.outcome import LEFT_WORLD, Outcome


@kind
class LeftWorldPenalty(RewardDefaults):
    """Penalty ``-weight``, once, when the episode ends outside the world's rectangle."""

    role: ClassVar[Role] = "penalty"
    outcome: ClassVar[Outcome] = Outcome.LEFT_WORLD
    needs_ending: ClassVar[bool] = True

    weight: float = option(4.0, ge=0.0, meaning="Penalty for leaving the world.")

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"-{self.weight:g}, once, when the episode ends outside the world"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the penalty."""
        pay_outcome(shard.worlds, term.column, LEFT_WORLD, -term.options.weight, episode)
