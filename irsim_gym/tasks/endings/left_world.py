"""Left the world: the agent is wholly outside the world's rectangle."""

from typing import ClassVar

from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Outcome, Shard, State, Term, kernel, kind, row_of


@kind
class LeftWorld:
    """End with failure when the agent is outside the world's rectangle by more than its own reach."""

    outcome: ClassVar[Outcome] = Outcome.LEFT_WORLD
    needs_goal: ClassVar[bool] = False

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        return "it is outside the world's rectangle by more than its own reach"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag."""
        find_outside(shard.worlds, term.agents, term.column, model, state, episode)


@kernel
def find_outside(worlds: Ints, agents: Ints, column: int, model: Model, state: State, episode: EpisodeState) -> None:
    """Write a column of ``ending``: whether the body's origin is outside ``bounds`` by more than its reach [m].

    Reads: model (bounds, reach), state (pose).
    Writes: episode (ending).
    """
    x_min, y_min, x_max, y_max = model.bounds[0], model.bounds[1], model.bounds[2], model.bounds[3]
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            r = model.reach[row_of(model.reach, w), b]
            x, y = state.pose[w, b, 0], state.pose[w, b, 1]
            episode.ending[w, a, column] = x < x_min - r or x > x_max + r or y < y_min - r or y > y_max + r
