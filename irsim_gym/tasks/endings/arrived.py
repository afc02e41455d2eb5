"""Arrived: the agent has reached its last goal."""

from typing import ClassVar

from irsim_gym.tasks.endings.body_flag import copy_flag
from irsim_gym.tasks.terms import EpisodeState, Model, Outcome, Shard, State, Term, kind, option


@kind
class Arrived:
    """End with success when the agent is within its goal threshold of the last goal.

    With ``wait``, the agent succeeds there, but its episode goes on, so that it can make way for others. It ends when
    no agent of the world is on its way any more, at the time limit, or by a failure, whose penalty is paid, but which
    does not undo the success. After its arrival, the agent gets no progress and has no running costs, and its path and
    its time do not grow.
    """

    outcome: ClassVar[Outcome] = Outcome.SUCCESS
    needs_goal: ClassVar[bool] = True

    wait: bool = option(False, meaning="Whether the agent drives on until the whole team has arrived or failed.")

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        there = "within its goal_threshold of its last goal"
        if not self.wait:
            return f"it is {there}"
        return f"it has been {there}, and no agent is on its way any more or the time is up; a later failure is success"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag; ``account.hold_arrivals`` lets agents wait."""
        copy_flag(shard.worlds, term.agents, term.column, state, episode)
