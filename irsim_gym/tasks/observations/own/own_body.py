"""Own body: how large, how fast and how agile the agent is."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.model import OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, Model
from irsim_gym.simulator.world.names import Ints, Rays, Shard, State, kernel, kind, row_of
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, Needs, RobotValues, Term, Value, unchanged

WIDTH = 8
HALF_RADIUS, HALF_STEP = 0.5, 0.1
"""Radius [m] and duration of a step [s] that read 0.5; limits of 1 do, in their units."""


@kind
class OwnBody:
    """Size, limits and step of the agent, for a policy that drives several robots.

    The numbers are the radius around the agent's origin, the greatest speeds ahead and back, the greatest value of the
    command's second component, 1 if that is a speed to the left and 0 if it turns, the acceleration limits of both
    components, and the duration of a step. A value x reads ``x / (x + half)``, with a ``half`` of 0.5 m, 0.1 s, and 1
    for limits; without a limit it reads 1.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ()

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return 0 and 1."""
        return np.zeros(WIDTH, np.float32), np.ones(WIDTH, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        (first, unit), (second, turning) = term.components[agent][:2]
        return [
            Columns("own radius", f"r / (r + {HALF_RADIUS:g} m)"),
            Columns(f"greatest value of {first}", f"v / (v + 1 {unit})"),
            Columns(f"greatest value of {first} backwards", f"v / (v + 1 {unit})"),
            Columns(f"greatest value of {second}", f"v / (v + 1 {turning})"),
            Columns(f"1 if {second} is a speed to the left", "0 if it turns the robot or its wheels"),
            Columns(f"greatest change of {first}", f"a / (a + 1 {unit}2), 1 without a limit"),
            Columns(f"greatest change of {second}", f"a / (a + 1 {turning}2), 1 without a limit"),
            Columns("duration of a step", f"t / (t + {HALF_STEP:g} s)"),
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns, which do not change."""
        return unchanged(WIDTH)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        b = term.agents[agent]
        low, high, limit = model.velocity_min[0, b], model.velocity_max[0, b], model.acceleration_limit[0, b]
        sideways = float(model.drive[b] in (OMNI_WORLD, OMNI_BODY, OMNI_ANGULAR))
        speeds = [share_of(v, 1.0) for v in (max(high[0], 0.0), abs(min(low[0], 0.0)), max(high[1], -low[1]))]
        changes = [share_of(limit[0], 1.0), share_of(limit[1], 1.0), share_of(model.step_time[0], HALF_STEP)]
        shares = [share_of(model.reach[0, b], HALF_RADIUS), *speeds, np.float32(sideways), *changes]
        return robot.constant(np.array(shares))

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the numbers."""
        write_own_body(shard.worlds, term.agents, term.column, model, episode)


@kernel
def write_own_body(worlds: Ints, agents: Ints, column: int, model: Model, episode: EpisodeState) -> None:
    """Write the eight numbers of each agent.

    Reads: model (acceleration_limit, drive, reach, step_time, velocity_max, velocity_min).
    Writes: episode (observation).
    """
    for w in worlds:
        low, high = model.velocity_min[row_of(model.velocity_min, w)], model.velocity_max[row_of(model.velocity_max, w)]
        limit = model.acceleration_limit[row_of(model.acceleration_limit, w)]
        reach = model.reach[row_of(model.reach, w)]
        for a in range(agents.shape[0]):
            b, row = agents[a], episode.observation[w, a, column : column + WIDTH]
            row[0] = share_of(reach[b], HALF_RADIUS)
            row[1] = share_of(max(high[b, 0], 0.0), 1.0)
            row[2] = share_of(np.abs(min(low[b, 0], 0.0)), 1.0)
            row[3] = share_of(max(high[b, 1], -low[b, 1]), 1.0)
            row[4] = np.float32(model.drive[b] in (OMNI_WORLD, OMNI_BODY, OMNI_ANGULAR))
            row[5] = share_of(limit[b, 0], 1.0)
            row[6] = share_of(limit[b, 1], 1.0)
            row[7] = share_of(model.step_time[0], HALF_STEP)


@kernel(inlined=True)
def share_of(value: float, half: float) -> np.float32:
    """Return value / (value + half), 1 for infinity."""
    return np.float32(value / (value + half) if value < np.inf else 1.0)
