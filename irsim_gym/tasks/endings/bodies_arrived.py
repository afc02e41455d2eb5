"""Bodies arrived: all bodies lie in their targets."""

from typing import ClassVar

from irsim_gym.tasks.terms import EpisodeState, Ints, Model, Outcome, Shard, Simulation, State, Term, kernel, kind
from irsim_gym.tasks.terms.targets import Targets, ToTargets, lies_there


@kind
class BodiesArrived(ToTargets):
    """End with success, for all agents, when all bodies lie in their targets at the same time.

    Bodies that a level leaves out do not count. A level in which all of them lie there from the start ends with its
    first step: keep starts and targets apart (``min_goal_distance`` of ``distribution``, or ranges outside the area).
    """

    outcome: ClassVar[Outcome] = Outcome.SUCCESS

    def arrays(self, simulation: Simulation, agents: Ints) -> Targets:
        """Return the bodies."""
        return self.targets(simulation, len(agents))

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        return "all bodies that are to be pushed lie in their targets"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag."""
        find_all_there(shard.worlds, term.column, term.arrays, model, state, episode)


@kernel
def find_all_there(
    worlds: Ints, column: int, targets: Targets, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write a column of ``ending``: whether there are bodies with targets, and all lie there.

    Reads: targets (area, bodies), model (arrive_mode, goal_threshold, present), state (goal, pose, waypoint,
        waypoint_end).
    Writes: episode (ending).
    """
    for w in worlds:
        count, missing = 0, 0
        for b in targets.bodies:
            if model.present[w, b]:
                count += 1
                missing += 0 if lies_there(w, b, targets.area, model, state) else 1
        for a in range(episode.ending.shape[1]):
            episode.ending[w, a, column] = count > 0 and missing == 0
