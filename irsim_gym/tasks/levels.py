"""Which level an episode plays: splits, levels and the chain of levels that follows a seed.

A level is (scenario, split, index); its random stream is keyed by a hash of all three. The streams of
``train``, ``dev`` and ``test`` are therefore different whatever indices are used, and training, which
stays within its split for ever, meets no level that is kept for choosing or for reporting.

Where a file gives the levels, level s is the file's level s modulo their number, and later ones are taken likewise.
"""

from __future__ import annotations

from irsim_gym.arraytypes import Ints, Words
from irsim_gym.errors import UnknownNameError, suggestion
from irsim_gym.jit import kernel
from irsim_gym.rng import later_level, level_key
from irsim_gym.scenario.level_set import SPLITS


def check_split(split: str) -> None:
    """Refuse a split that does not exist.

    Raises:
        UnknownNameError: It is none of ``train``, ``dev``, ``test``.
    """
    if split not in SPLITS:
        raise UnknownNameError(f"no split named '{split}'{suggestion(split, SPLITS)}; splits: {', '.join(SPLITS)}")


@kernel
def take_levels(
    worlds: Ints, base: Words, count: Ints, first_level: Ints, episode: Ints, level: Ints, stream: Words
) -> None:
    """Write the level of each world's present episode and what it is taken from, see ``rng.level_key``.

    Args:
        worlds: The worlds to treat.
        base: Key of the split, or its first row in a file, ``(n_worlds,)``.
        count: Number of its levels in a file; 0 where they are drawn, ``(n_worlds,)``.
        first_level: First level of each world's chain, ``(n_worlds,)``.
        episode: Number of the episode in the chain, ``(n_worlds,)``.
        level: Written, ``(n_worlds, n_agents)``.
        stream: Written, ``(n_worlds,)``.
    """
    for w in worlds:
        here = later_level(int(first_level[w]), int(episode[w]))
        stream[w] = level_key(base[w], int(count[w]), int(here))
        here = here % count[w] if count[w] > 0 else here
        for a in range(level.shape[1]):
            level[w, a] = here
