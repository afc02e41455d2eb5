"""Body arrival: the bonus for each body that is pushed into its target."""

from typing import ClassVar

from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.tasks.terms.outcome import Outcome
from irsim_gym.tasks.terms.targets import Targets, ToTargets, lies_there
from irsim_gym.tasks.terms.term import Bound, Role, Term


@kind
class BodyArrival(ToTargets):
    """Bonus ``+weight`` for each body, once, when it comes to lie in its target.

    A body that lies there when the episode begins is never paid for, nor one that is pushed out and in again. All
    agents of a world are paid.
    """

    role: ClassVar[Role] = "bonus"
    outcome: ClassVar[Outcome] = Outcome.SUCCESS
    needs_ending: ClassVar[bool] = False

    weight: float = option(1.0, ge=0.0, meaning="Bonus for each body.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Targets:
        """Return the bodies, and which of them have been paid for."""
        return self.targets(simulation, len(agents))

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Note the bodies that lie in their targets at the start."""
        note_there(shard.worlds, term.arrays, model, state, episode)

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"+{self.weight:g} for each body, once, when it comes to lie in its target"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the bonus for the bodies that have arrived in this step."""
        pay_arrivals(shard.worlds, term.bound, term.arrays, model, state, episode)


@kernel
def note_there(worlds: Ints, targets: Targets, model: Model, state: State, episode: EpisodeState) -> None:
    """Write which bodies lie in their targets, for agents whose episode begins.

    Reads: targets (area, bodies), model (arrive_mode, goal_threshold), state (goal, pose, waypoint, waypoint_end),
        episode (began).
    Writes: targets (counted).
    """
    for w in worlds:
        for a in range(episode.began.shape[1]):
            for k in range(targets.bodies.shape[0] if episode.began[w, a] else 0):
                targets.counted[w, a, k] = lies_there(w, targets.bodies[k], targets.area, model, state)


@kernel
def pay_arrivals(
    worlds: Ints, term: Bound, targets: Targets, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the weighted number of bodies that lie in their targets for the first time, and count them.

    Reads: term (column, options), targets (area, bodies, counted), model (arrive_mode, goal_threshold, present), state
        (goal, pose, waypoint, waypoint_end).
    Writes: targets (counted), episode (reward_term).
    """
    for w in worlds:
        for a in range(episode.reward_term.shape[1]):
            count = 0
            for k in range(targets.bodies.shape[0]):
                b = targets.bodies[k]
                if (
                    not targets.counted[w, a, k]
                    and model.present[w, b]
                    and lies_there(w, b, targets.area, model, state)
                ):
                    targets.counted[w, a, k] = True
                    count += 1
            episode.reward_term[w, a, term.column] = term.options[0].weight * count
