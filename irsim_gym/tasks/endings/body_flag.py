"""Copies a flag of bodies as an ending."""

from irsim_gym.tasks.terms import EpisodeState, Ints, State, kernel


@kernel
def copy_flag(worlds: Ints, agents: Ints, column: int, state: State, episode: EpisodeState) -> None:
    """Copy the flag ``arrived`` of the agents' bodies into a column of ``ending``.

    Reads: state (arrived).
    Writes: episode (ending).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            episode.ending[w, a, column] = state.arrived[w, agents[a]]
