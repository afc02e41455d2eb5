"""Velocity: how fast the agent is."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.engine import Shard
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Term
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kind
class Velocity:
    """The velocity executed in the latest step, each component over the larger of its two limits."""

    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    def bounds(self, term: Term, model: WorldModel) -> tuple[Rays, Rays]:
        """Return the limits themselves, scaled; an agent at rest is always within them."""
        low = np.zeros(term.action_size, np.float32)
        high = np.zeros(term.action_size, np.float32)
        for c in range(term.action_size):
            slowest, fastest = model.velocity_min[:, term.agents, c], model.velocity_max[:, term.agents, c]
            largest = np.maximum(np.abs(slowest), np.abs(fastest))
            scale = np.where(largest > 0.0, largest, 1.0)
            low[c] = min(0.0, np.min(slowest / scale))
            high[c] = max(0.0, np.max(fastest / scale))
        return low, high

    @staticmethod
    def write(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Write the velocity."""
        write_velocity(
            shard.worlds,
            term.agents,
            term.column,
            term.action_size,
            model.velocity_min,
            model.velocity_max,
            state.stopped,
            state.velocity,
            episode.observation,
        )


@kernel
def write_velocity(
    worlds: Ints,
    agents: Ints,
    column: int,
    size: int,
    velocity_min: Floats,
    velocity_max: Floats,
    stopped: Flags,
    velocity: Floats,
    out: Rays,
) -> None:
    """Write ``size`` components of the velocity over max(abs(velocity_min), abs(velocity_max)); 0 when stopped."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        slowest, fastest = velocity_min[w % velocity_min.shape[0]], velocity_max[w % velocity_max.shape[0]]
        for a in range(agents.shape[0]):
            b = agents[a]
            for c in range(size):
                low, high = slowest[b, c], fastest[b, c]
                largest = max(np.abs(low), np.abs(high))
                scaled = 0.0
                if largest > 0.0 and not stopped[w, b]:
                    scaled = min(max(velocity[w, b, c] / largest, min(low / largest, 0.0)), max(high / largest, 0.0))
                out[w, a, column + c] = np.float32(scaled)
