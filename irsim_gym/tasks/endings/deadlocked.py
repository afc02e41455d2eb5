"""Deadlocked: the agent has stood still for too long."""

from typing import ClassVar

from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Outcome, Shard, State, Term, kernel, kind


@kind
class Deadlocked:
    """End with failure when the agent has been slower than the task's ``deadlock_speed`` for ``deadlock_time``."""

    outcome: ClassVar[Outcome] = Outcome.DEADLOCK
    needs_goal: ClassVar[bool] = True

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        return "it has been slower than deadlock_speed, away from its goal, for deadlock_time (see the task)"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag."""
        copy_deadlocks(shard.worlds, term.column, episode)


@kernel
def copy_deadlocks(worlds: Ints, column: int, episode: EpisodeState) -> None:
    """Copy the flag of each agent into a column of ``ending``.

    Reads: episode (deadlocked).
    Writes: episode (ending).
    """
    for w in worlds:
        for a in range(episode.deadlocked.shape[1]):
            episode.ending[w, a, column] = episode.deadlocked[w, a]
