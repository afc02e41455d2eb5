"""A flag of a body as an ending of its agent."""

from __future__ import annotations

from irsim_gym.arraytypes import Flags, Ints
from irsim_gym.jit import kernel


@kernel
def copy_flag(worlds: Ints, agents: Ints, column: int, flag: Flags, ending: Flags) -> None:
    """Copy the agents' entries of a flag of bodies, ``(n_worlds, n_bodies)``, into a column of ``ending``."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            ending[w, a, column] = flag[w, agents[a]]
