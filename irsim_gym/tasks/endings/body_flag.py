"""A flag of a body as an ending of its agent."""

from __future__ import annotations

from irsim_gym.arraytypes import Ints
from irsim_gym.jit import kernel
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.world.state import WorldState


@kernel
def copy_flag(worlds: Ints, agents: Ints, column: int, state: WorldState, episode: EpisodeState) -> None:
    """Copy the agents' entries of a flag of bodies, ``(n_worlds, n_bodies)``, into a column of ``ending``.

    Reads: state (arrived).
    Writes: episode (ending).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            episode.ending[w, a, column] = state.arrived[w, agents[a]]
