"""Arrival: the bonus for success."""

from typing import ClassVar

from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Role, Shard, State, Term, kernel, kind, option
from irsim_gym.tasks.terms.outcome import SUCCESS, Outcome


@kind
class Arrival:
    """Bonus ``+weight``, once, when the agent succeeds; see ``arrived`` for agents that drive on."""

    role: ClassVar[Role] = "bonus"
    outcome: ClassVar[Outcome] = Outcome.SUCCESS
    needs_goal: ClassVar[bool] = True
    needs_ending: ClassVar[bool] = True

    weight: float = option(5.0, ge=0.0, meaning="Bonus for success.")

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"+{self.weight:g}, once, when it reaches its last goal"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the bonus."""
        pay_success(shard.worlds, term.column, term.options.weight, episode)


@kernel
def pay_success(worlds: Ints, column: int, amount: float, episode: EpisodeState) -> None:
    """Write ``amount`` in the step of an arrival that waits, or at the end with success, else 0.

    Reads: episode (arrival, outcome, steps).
    Writes: episode (reward_term).
    """
    for w in worlds:
        for a in range(episode.outcome.shape[1]):
            arrival = episode.arrival[w, a]
            succeeds = arrival == episode.steps[w, a] if arrival > 0 else episode.outcome[w, a] == SUCCESS
            episode.reward_term[w, a, column] = amount if succeeds else 0.0
