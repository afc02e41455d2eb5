"""Clearance: the cost of passing close to other bodies."""

from irsim_gym.tasks.terms import EpisodeState, Ints, Model, RewardDefaults, Shard, State, Term, kernel, kind, option


@kind
class Clearance(RewardDefaults):
    """Cost of closeness: ``max(0, 1 - clearance / safe)^2``, times ``weight / max_steps``."""

    weight: float = option(0.8, ge=0.0, meaning="Cost of an episode spent in contact.")
    safe: float = option(0.3, gt=0.0, unit="m", meaning="Clearance from which the cost is zero.")

    @property
    def clearance_range(self) -> float:
        """Clearance up to which the value must be exact [m]."""
        return self.safe

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        most = self.weight / term.max_steps
        return f"nearer than {self.safe:g} m to another body: -{most:.3g} (1 - clearance / {self.safe:g} m)^2 a step"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the cost of the present clearance."""
        amount = -term.options.weight / term.max_steps
        pay_closeness(shard.worlds, term.column, amount, term.options.safe, episode)


@kernel
def pay_closeness(worlds: Ints, column: int, amount: float, safe: float, episode: EpisodeState) -> None:
    """Write ``amount`` times the squared shortfall of the clearance [m], relative to ``safe`` [m].

    Reads: episode (clearance).
    Writes: episode (reward_term).
    """
    for w in worlds:
        for a in range(episode.clearance.shape[1]):
            short = max(0.0, 1.0 - episode.clearance[w, a] / safe)
            episode.reward_term[w, a, column] = amount * short * short
