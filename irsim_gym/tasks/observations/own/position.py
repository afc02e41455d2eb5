"""Position: the position of the agent in the world."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, kernel, kind
from irsim_gym.tasks.terms import IN_WORLD, Columns, EpisodeState, Needs, RobotValues, Term, Value


@kind
class Position:
    """x and y relative to the world's centre, divided by half its longer side, so that the world lies within [-1, 1].

    The numbers continue beyond the world's edge, so that different positions stay different.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ("map_frame",)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return infinite bounds."""
        return np.full(2, -np.inf, np.float32), np.full(2, np.inf, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return [Columns(f"{axis} of the agent's place", place_scale(axis, model)) for axis in ("x", "y")]

    def mirrored(self, term: Term) -> str:
        """Return why it has no mirror: it is in the frame of the world."""
        return IN_WORLD

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        low, high = model.bounds[:2], model.bounds[2:]
        place = robot.pose.columns(0, 2) - 0.5 * (low + high)
        return (place / (0.5 * float(np.max(high - low)))).cast(np.float32)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the two elements."""
        write_place(shard.worlds, term.agents, term.column, model, episode, state.pose)


def place_scale(axis: str, model: Model) -> str:
    """Return the formula for a coordinate's number, as text."""
    x_min, y_min, x_max, y_max = model.bounds.tolist()
    middle = 0.5 * (x_min + x_max) if axis == "x" else 0.5 * (y_min + y_max)
    return f"({axis} - {middle:g} m) / {0.5 * max(x_max - x_min, y_max - y_min):g} m"


@kernel
def write_place(worlds: Ints, agents: Ints, column: int, model: Model, episode: EpisodeState, places: Floats) -> None:
    """Write x and y of the agents' rows of ``places``, ``(n_worlds, n_bodies, 3)`` [m], scaled by the world's size.

    Reads: model (bounds).
    Writes: episode (observation).
    """
    half = 0.5 * max(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1])
    middle_x, middle_y = 0.5 * (model.bounds[0] + model.bounds[2]), 0.5 * (model.bounds[1] + model.bounds[3])
    for w in worlds:
        for a in range(agents.shape[0]):
            episode.observation[w, a, column] = np.float32((places[w, agents[a], 0] - middle_x) / half)
            episode.observation[w, a, column + 1] = np.float32((places[w, agents[a], 1] - middle_y) / half)
