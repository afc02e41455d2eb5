"""Goal position: the position of the next goal in the world."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from irsim_gym.tasks.graph import RobotValues, Value
from irsim_gym.tasks.observations.position import place_graph, place_scale, write_place
from irsim_gym.tasks.term import Needs
from irsim_gym.tasks.terms import IN_WORLD, Columns, EpisodeState, Model, Rays, Shard, State, Term, kind


@kind
class GoalPosition:
    """x and y of the next goal, scaled like ``position``."""

    needs_goal: ClassVar[bool] = True
    needs: ClassVar[Needs] = ("map_frame",)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return infinite bounds."""
        return np.full(2, -np.inf, np.float32), np.full(2, np.inf, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return [Columns(f"{axis} of the next goal", place_scale(axis, model)) for axis in ("x", "y")]

    def mirrored(self, term: Term) -> str:
        """Return why it has no mirror: it is in the frame of the world."""
        return IN_WORLD

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        return place_graph(model, robot.goal)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the two elements."""
        write_place(shard.worlds, term.agents, term.column, model, episode, state.goal)
