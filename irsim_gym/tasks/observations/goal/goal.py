"""Goal: the next goal relative to the agent."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.geometry.angles import turned
from irsim_gym.simulator.world.names import Ints, Model, Rays, Shard, State, kernel, kind, option
from irsim_gym.tasks.observations.seen_map.way_columns import write_direction
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Mirrored, RobotValues, Term, Value, diagonal, signed
from irsim_gym.tasks.terms.term import Needs


@kind
class Goal:
    """Distance and bearing of the next goal: ``min(d / scale, 1)``, cosine and sine of the bearing, ``exp(-d / near)``.

    The bearing is given as cosine and sine, because an angle would jump where it wraps.
    """

    needs_goal: ClassVar[bool] = True
    needs: ClassVar[Needs] = ("odometry",)

    scale: float | None = option(None, gt=0.0, unit="m", meaning="Distance that reads 1; default: world's diagonal.")
    near: float = option(1.0, gt=0.0, unit="m", meaning="Distance over which the near term falls to 1/e.")

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the four elements."""
        return np.array([0.0, -1.0, -1.0, 0.0], np.float32), np.ones(4, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        full = self.scale or diagonal(model.bounds)
        bearing = "0 straight ahead, positive to the left"
        return [
            Columns("distance d of the next goal", f"d / {full:.3g} m, at most 1"),
            Columns("cosine of the goal's bearing: 1 straight ahead, -1 straight behind", bearing),
            Columns("sine of the goal's bearing: 1 to the left, -1 to the right", bearing),
            Columns("nearness of the goal", f"exp(-d / {self.near:g} m)"),
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, 1.0, -1.0, 1.0)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        ways = robot.ways(robot.goal.columns(0, 2).spread(1))
        d, full = ways.length(2), self.scale or diagonal(model.bounds)
        columns = [(d / full).least(1.0), robot.direction(ways), (d / -self.near).op("Exp")]
        return robot.graph.join(columns).cast(np.float32)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the four elements."""
        write_goal(shard.worlds, term.bound, model, state, episode)


@kernel
def write_goal(worlds: Ints, term: Bound, model: Model, state: State, episode: EpisodeState) -> None:
    """Write distance, cosine and sine of the bearing (1, 0 at the goal itself) and the near term.

    Reads: term (agents, column, options), model (bounds), state (direction, goal, pose).
    Writes: episode (observation).
    """
    options, agents, column = term.options[0], term.agents, term.column
    full = diagonal(model.bounds) if np.isnan(options.scale) else options.scale
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            row = episode.observation[w, a, column : column + 4]
            place, there = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            d = write_direction(row[1:], place, turned(state.pose[w, b, 2], state.direction[w, b]), there)
            row[0] = np.float32(min(d / full, 1.0))
            row[3] = np.float32(np.exp(-d / options.near))
