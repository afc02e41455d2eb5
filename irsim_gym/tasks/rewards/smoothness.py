"""Smoothness: the cost of changing the action."""

from irsim_gym.tasks.terms import EpisodeState, Ints, Model, RewardDefaults, Shard, State, Term, kernel, kind, option


@kind
class Smoothness(RewardDefaults):
    """Cost of abrupt actions: ``|a_t - a_(t-1)|^2`` over its largest possible value, times ``weight / max_steps``."""

    weight: float = option(0.2, ge=0.0, meaning="Cost of an episode in which every action jumps between its bounds.")

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        most = f"-{self.weight / term.max_steps:.3g} per step for a change between the bounds"
        return f"the action changes: at most {most}, with the square of the change"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the cost of the latest change."""
        pay_change(shard.worlds, term.column, -term.options.weight / term.max_steps, term.action_sizes, episode)


@kernel
def pay_change(worlds: Ints, column: int, amount: float, sizes: Ints, episode: EpisodeState) -> None:
    """Write ``amount`` times the squared change of the action, scaled to [0, 1]; actions lie in [-1, 1].

    Reads: episode (action, previous_action).
    Writes: episode (reward_term).
    """
    for w in worlds:
        for a in range(episode.action.shape[1]):
            squared = 0.0
            for c in range(episode.action.shape[2]):
                change = episode.action[w, a, c] - episode.previous_action[w, a, c]
                squared += change * change
            # Each component changes by 2 at most, from bound to bound: 4 squared, for as many as the agent has.
            episode.reward_term[w, a, column] = amount * squared / (4.0 * sizes[a])
