"""Velocity: the velocity of the agent."""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.simulator.levels.traits import limits_at_ends
from irsim_gym.simulator.world.model import OMNI_WORLD, Model
from irsim_gym.simulator.world.names import Flags, Floats, Ints, Rays, Shard, State, kernel, kind, row_of
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, RobotValues, Simulation, Value, command_exchanged
from irsim_gym.tasks.terms.term import AHEAD_AND_LEFT, Needs, Term


@kind
class Velocity:
    """The velocity executed in the latest step, each component divided by the larger of its two limits.

    For an ``omni`` drive, it is the velocity in the body frame, divided by the length of the vector of both limits.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ("odometry",)

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return each agent's limits with the least and the greatest speed of any level, ``(n_agents, 2, 3)``."""
        ends = [limits_at_ends(simulation.parts.traits, simulation.model, int(b)) for b in agents]
        return {"slowest": np.stack([low for low, _ in ends]), "fastest": np.stack([high for _, high in ends])}

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the scaled velocity limits of any level, extended to include 0."""
        slowest, fastest = (term.arrays[name][..., : term.action_size] for name in ("slowest", "fastest"))
        largest = np.maximum(np.abs(slowest), np.abs(fastest))
        scale = np.where(largest > 0.0, largest, 1.0)
        low = np.min(slowest / scale, axis=(0, 1), initial=0.0).astype(np.float32)
        high = np.max(fastest / scale, axis=(0, 1), initial=0.0).astype(np.float32)
        if np.any(model.drive[term.agents] == OMNI_WORLD):
            low[:2], high[:2] = -1.0, 1.0
        return low, high

    def used(self, term: Term) -> Flags:
        """Return flags of the components that each agent's drive has, ``(n_agents, action_size)``."""
        return np.arange(term.action_size) < term.action_sizes[:, None]

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns; components that an agent lacks are 0."""
        ends = np.maximum(np.abs(term.arrays["slowest"][agent]), np.abs(term.arrays["fastest"][agent]))
        words = term.components[agent]
        if model.drive[term.agents[agent]] == OMNI_WORLD:
            words, ends = AHEAD_AND_LEFT, np.repeat(np.hypot(ends[:, :1], ends[:, 1:2]), 3, axis=1)
        pairs = zip(words, ends.T.tolist(), strict=False)
        columns = [Columns(name, _scale(least, most, unit)) for (name, unit), (least, most) in pairs]
        return [*columns, *[Columns("unused")] * (term.action_size - len(columns))]

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the columns as the drive says; what is positive to the left changes its sign."""
        return command_exchanged(term)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        b, size = term.agents[agent], term.action_size
        low, high = np.minimum(model.velocity_min[0, b, :size], 0.0), np.maximum(model.velocity_max[0, b, :size], 0.0)
        largest = np.maximum(-low, high)
        velocity = robot.velocity.between(low, high)
        if model.drive[b] == OMNI_WORLD:
            largest = np.full(size, np.hypot(largest[0], largest[1]))
            velocity = robot.velocity.between(-largest, largest)
        return (velocity / np.where(largest > 0.0, largest, 1.0)).cast(np.float32)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the velocity."""
        write_velocity(shard.worlds, term.agents, term.column, term.action_size, model, state, episode)


def _scale(least: float, most: float, unit: str) -> str:
    """Return the formula of a component whose larger limit is drawn from ``least`` to ``most``, as text."""
    drawn = f"{most:.4g}" if least == most else f"the level's limit, {round(least, 6):g} to {most:.4g}"
    return f"v / {drawn} {unit}".strip()


@kernel
def write_velocity(
    worlds: Ints, agents: Ints, column: int, size: int, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write ``size`` components of the velocity over max(abs(velocity_min), abs(velocity_max)); 0 if stopped.

    Reads: model (drive, velocity_max, velocity_min), state (pose, stopped, velocity).
    Writes: episode (observation).
    """
    for w in worlds:
        slowest = model.velocity_min[row_of(model.velocity_min, w)]
        fastest = model.velocity_max[row_of(model.velocity_max, w)]
        for a in range(agents.shape[0]):
            b = agents[a]
            if model.drive[b] == OMNI_WORLD:
                heading, row = state.pose[w, b, 2], episode.observation[w, a, column:]
                write_turned(heading, state.velocity[w, b], slowest[b], fastest[b], state.stopped[w, b], row)
                continue
            for c in range(size):
                low, high = slowest[b, c], fastest[b, c]
                largest = max(np.abs(low), np.abs(high))
                scaled = 0.0
                if largest > 0.0 and not state.stopped[w, b]:
                    # Limits that exclude 0 are widened to it, as a body at rest has velocity 0.
                    scaled = min(max(state.velocity[w, b, c], min(low, 0.0)), max(high, 0.0)) / largest
                episode.observation[w, a, column + c] = np.float32(scaled)


@kernel
def write_turned(
    heading: float, velocity: Floats, slowest: Floats, fastest: Floats, is_stopped: bool, out: Rays
) -> None:
    """Write a world-frame velocity in the body frame, over the length of the vector of both limits; 0 if stopped."""
    x, y = max(np.abs(slowest[0]), np.abs(fastest[0])), max(np.abs(slowest[1]), np.abs(fastest[1]))
    largest = np.sqrt(x * x + y * y)
    share = 0.0 if is_stopped or largest == 0.0 else 1.0 / largest
    cosine, sine = np.cos(heading), np.sin(heading)
    ahead, left = cosine * velocity[0] + sine * velocity[1], cosine * velocity[1] - sine * velocity[0]
    out[0] = np.float32(min(max(share * ahead, -1.0), 1.0))
    out[1] = np.float32(min(max(share * left, -1.0), 1.0))
