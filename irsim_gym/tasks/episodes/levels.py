"""Determines the level of an episode: splits, levels, the chain of levels that follows a seed, and chosen levels.

A level is (scenario, split, index); its random stream is keyed by a hash of all three. Therefore the streams of
``train``, ``dev`` and ``test`` differ for all indices, and training, which stays within its split, never meets a level
that is reserved for model selection or for reporting.

A world's next level may be chosen instead of the next one in its chain. It is a level of the same split.

If a file gives the levels, level s is the file's level s modulo their number.
"""

from irsim_gym.base.errors import UnknownNameError, suggestion
from irsim_gym.base.rng import later_level, level_key
from irsim_gym.scenario.specs.level_set import SPLITS
from irsim_gym.tasks.terms import EpisodeState, Ints, kernel

CHAIN = -1
"""Value for no chosen level: the next one in the world's chain."""


def check_split(split: str) -> None:
    """Check that a split exists.

    Raises:
        UnknownNameError: If the split is none of ``train``, ``dev``, ``test``.
    """
    if split not in SPLITS:
        raise UnknownNameError(f"no split named '{split}'{suggestion(split, SPLITS)}; splits: {', '.join(SPLITS)}")


@kernel
def take_levels(worlds: Ints, episode: EpisodeState) -> None:
    """Write the level of each world's present episode, chosen or from its chain, and its ``rng.level_key``.

    Reads: episode (base, chosen, count, episode, first_level).
    Writes: episode (chosen, level, stream).
    """
    for w in worlds:
        level, count = episode.chosen[w], episode.count[w]
        if level == CHAIN:
            level = later_level(int(episode.first_level[w]), int(episode.episode[w]))
        episode.chosen[w] = CHAIN
        episode.stream[w] = level_key(episode.base[w], int(count), int(level))
        # With a file of levels, what is reported is the number of the level in its split.
        level = level % count if count > 0 else level
        for a in range(episode.level.shape[1]):
            episode.level[w, a] = level
