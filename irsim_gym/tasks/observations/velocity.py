"""Velocity: the velocity of the agent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.engine import Shard
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import Mirrored, command_exchanged
from irsim_gym.tasks.term import AHEAD_AND_LEFT, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import OMNI_WORLD, Model
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import State


@kind
class Velocity:
    """The velocity executed in the latest step, each component divided by the larger of its two limits.

    For an ``omni`` drive, it is the velocity in the body frame, divided by the length of the vector of both limits.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the scaled velocity limits, extended to include 0."""
        low = np.zeros(term.action_size, np.float32)
        high = np.zeros(term.action_size, np.float32)
        for c in range(term.action_size):
            slowest, fastest = model.velocity_min[:, term.agents, c], model.velocity_max[:, term.agents, c]
            largest = np.maximum(np.abs(slowest), np.abs(fastest))
            scale = np.where(largest > 0.0, largest, 1.0)
            low[c] = min(0.0, np.min(slowest / scale))
            high[c] = max(0.0, np.max(fastest / scale))
        if np.any(model.drive[term.agents] == OMNI_WORLD):
            low[:2], high[:2] = -1.0, 1.0
        return low, high

    def used(self, term: Term) -> Flags:
        """Return flags of the components that each agent's drive has, ``(n_agents, action_size)``."""
        return np.arange(term.action_size) < term.action_sizes[:, None]

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns; components that an agent lacks are 0."""
        body = term.agents[agent]
        largest = np.maximum(np.abs(model.velocity_min), np.abs(model.velocity_max)).max(axis=0)[body]
        words = term.components[agent]
        if model.drive[body] == OMNI_WORLD:
            words, largest = AHEAD_AND_LEFT, np.full(3, np.hypot(*largest[:2]))
        columns = [
            Columns(name, f"v / {most:.4g} {unit}".strip()) for (name, unit), most in zip(words, largest, strict=False)
        ]
        return [*columns, *[Columns("unused")] * (term.action_size - len(columns))]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return command_exchanged(term.action_size)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the velocity."""
        write_velocity(shard.worlds, term.agents, term.column, term.action_size, model, state, episode)


@kernel
def write_velocity(
    worlds: Ints, agents: Ints, column: int, size: int, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write ``size`` components of the velocity over max(abs(velocity_min), abs(velocity_max)); 0 if stopped.

    Reads: model (drive, velocity_max, velocity_min), state (pose, stopped, velocity).
    Writes: episode (observation).
    """
    for w in worlds:
        slowest, fastest = (
            model.velocity_min[row_of(model.velocity_min, w)],
            model.velocity_max[row_of(model.velocity_max, w)],
        )
        for a in range(agents.shape[0]):
            b = agents[a]
            if model.drive[b] == OMNI_WORLD:
                write_turned(
                    state.pose[w, b, 2],
                    state.velocity[w, b],
                    slowest[b],
                    fastest[b],
                    state.stopped[w, b],
                    episode.observation[w, a, column:],
                )
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
