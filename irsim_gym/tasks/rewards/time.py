"""Time: the constant cost of each step."""

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.tasks.terms import EpisodeState, Model, RewardDefaults, Shard, State, Term, kernel, kind, option


@kind
class Time(RewardDefaults):
    """Cost of time: ``-weight`` spread evenly over the steps of a full episode."""

    weight: float = option(2.0, ge=0.0, meaning="Cost of a full episode; a step costs weight / max_steps.")

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"-{self.weight / term.max_steps:.3g} in each step"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the cost of a step."""
        fill(shard.worlds, term.column, -term.options.weight / term.max_steps, episode.reward_term)


@kernel
def fill(worlds: Ints, column: int, amount: float, out: Floats) -> None:
    """Write one amount into a column for all agents of the worlds."""
    for w in worlds:
        for a in range(out.shape[1]):
            out[w, a, column] = amount
