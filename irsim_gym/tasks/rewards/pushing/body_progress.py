"""Body progress: the reward for pushing bodies towards their targets, and the equal cost of pushing them away."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.tasks.terms.outcome import Outcome
from irsim_gym.tasks.terms.scaling import diagonal
from irsim_gym.tasks.terms.targets import Targets, ToTargets, way_to_target
from irsim_gym.tasks.terms.term import Bound, Role, Term


@kind
class BodyProgress(ToTargets):
    """``weight`` times the progress of bodies towards their targets in the step, summed, divided by the diagonal.

    As with ``progress``, it is measured to the goals before the step. All agents of a world are paid for all bodies.
    """

    role: ClassVar[Role] = "potential"
    outcome: ClassVar[Outcome] = Outcome.RUNNING
    needs_ending: ClassVar[bool] = False

    weight: float = option(4.0, ge=0.0, meaning="Reward for progress of one diagonal of the world.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Targets:
        """Return the bodies, their goals and distances one step ago."""
        return self.targets(simulation, len(agents))

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Store goals and distances."""
        note_targets(shard.worlds, term.arrays, state)

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        return f"{self.weight:g} times the way that bodies came nearer to their targets, over the world's diagonal"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the gain since the previous step, and store goals and distances."""
        pay_body_gain(shard.worlds, term.bound, term.arrays, model, state, episode)
        note_targets(shard.worlds, term.arrays, state)


@kernel
def note_targets(worlds: Ints, targets: Targets, state: State) -> None:
    """Store the goals of bodies, and their distances from their targets [m].

    Reads: targets (area, bodies, goal), state (goal, pose).
    Writes: targets (distance, goal).
    """
    for w in worlds:
        for k in range(targets.bodies.shape[0]):
            b, goal = targets.bodies[k], targets.goal[w, k]
            goal[0], goal[1] = state.goal[w, b, 0], state.goal[w, b, 1]
            dx, dy = way_to_target(w, b, targets.area, goal, state)
            targets.distance[w, k] = np.sqrt(dx * dx + dy * dy)


@kernel
def pay_body_gain(
    worlds: Ints, term: Bound, targets: Targets, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the weighted decrease of the distances from the stored targets, over the diagonal of ``bounds``.

    Reads: term (column, options), targets (area, bodies, distance, goal), model (bounds, present), state (pose).
    Writes: episode (reward_term).
    """
    rate = term.options[0].weight / diagonal(model.bounds)
    for w in worlds:
        gain = 0.0
        for k in range(targets.bodies.shape[0]):
            b = targets.bodies[k]
            if model.present[w, b]:
                dx, dy = way_to_target(w, b, targets.area, targets.goal[w, k], state)
                gain += targets.distance[w, k] - np.sqrt(dx * dx + dy * dy)
        for a in range(episode.reward_term.shape[1]):
            episode.reward_term[w, a, term.column] = rate * gain
