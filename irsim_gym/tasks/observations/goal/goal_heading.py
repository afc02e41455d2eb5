"""Goal heading: the heading that the next goal requires."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Ints, Model, Rays, Shard, State, kernel, kind
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, Needs, RobotValues, Term, Value, signed


@kind
class GoalHeading:
    """Cosine and sine of the turn to the goal's heading; both 0 if any heading is allowed."""

    needs_goal: ClassVar[bool] = True
    needs: ClassVar[Needs] = ("odometry",)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the two elements."""
        return np.full(2, -1.0, np.float32), np.ones(2, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        turn = "turn = goal's heading - own heading; both elements 0 if any heading is allowed"
        return [Columns("cosine of the remaining turn", turn), Columns("sine of the turn: positive to the left", turn)]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        turn = robot.goal.columns(2, 3) - robot.pose.columns(2, 3)
        return (~turn.is_nan()).where(turn.unit(), 0.0).cast(np.float32)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the two elements."""
        write_goal_heading(shard.worlds, term.agents, term.column, state, episode)


@kernel
def write_goal_heading(worlds: Ints, agents: Ints, column: int, state: State, episode: EpisodeState) -> None:
    """Write cosine and sine of goal heading minus heading.

    Reads: state (goal, pose).
    Writes: episode (observation).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            turn = state.goal[w, agents[a], 2] - state.pose[w, agents[a], 2]
            has_turn = not np.isnan(turn)
            episode.observation[w, a, column] = np.float32(np.cos(turn)) if has_turn else np.float32(0.0)
            episode.observation[w, a, column + 1] = np.float32(np.sin(turn)) if has_turn else np.float32(0.0)
