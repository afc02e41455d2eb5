"""An amount that is paid once, when an episode ends with a certain outcome."""

from irsim_gym.tasks.terms import EpisodeState, Ints, kernel


@kernel
def pay_outcome(worlds: Ints, column: int, outcome: int, amount: float, episode: EpisodeState) -> None:
    """Write ``amount`` if the outcome is ``outcome``, else 0.

    Reads: episode (outcome).
    Writes: episode (reward_term).
    """
    for w in worlds:
        for a in range(episode.outcome.shape[1]):
            episode.reward_term[w, a, column] = amount if episode.outcome[w, a] == outcome else 0.0
