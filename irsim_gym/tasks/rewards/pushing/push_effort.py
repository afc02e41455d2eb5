"""Push effort: the cost of the work that an agent does on what it pushes."""

from irsim_gym.base.arraytypes import Records
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.tasks.terms.targets import without_contacts
from irsim_gym.tasks.terms.term import Bound, RewardDefaults, Term


@kind
class PushEffort(RewardDefaults):
    """Cost of pushing: ``min(1, P / power)`` times ``weight / max_steps``, where P is the power against what it pushes.

    The power is the agent's speed against the force that it feels; what pushes the agent costs nothing.
    """

    weight: float = option(0.5, ge=0.0, meaning="Cost of an episode of pushing with the greatest power.")
    power: float = option(5.0, gt=0.0, unit="W", meaning="Power that costs most; more costs as much.")

    def misfit(self, scenario: Scenario) -> str | None:
        """Return what the scenario lacks, as text."""
        return without_contacts(scenario)

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, Records]:
        """Return what all bodies feel."""
        return {"felt": simulation.context.pushing.felt}

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"pushing with a power of P: -{self.weight / term.max_steps:.3g} min(1, P / {self.power:g} W) a step"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the cost of the step's work."""
        pay_work(shard.worlds, term.bound, term.arrays["felt"], term.max_steps, state, episode)


@kernel
def pay_work(worlds: Ints, term: Bound, felt: Records, max_steps: int, state: State, episode: EpisodeState) -> None:
    """Write the cost of the power of each agent against the force on it.

    Reads: term (agents, column, options), state (twist).
    Writes: episode (reward_term).
    """
    options = term.options[0]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b = term.agents[a]
            power = max(0.0, -(felt[w, b].x * state.twist[w, b, 0] + felt[w, b].y * state.twist[w, b, 1]))
            episode.reward_term[w, a, term.column] = -options.weight / max_steps * min(1.0, power / options.power)
