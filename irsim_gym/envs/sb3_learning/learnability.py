"""Sampling for learnability: which levels are played again.

The learnability of a level is p (1 - p), where p is the probability that the policy succeeds in it (Rutherford et al.,
"No Regrets: Investigating and Improving Regret Approximations for Curriculum Discovery", NeurIPS 2024). The paper
estimates p by extra rollouts. Here it is estimated from the training episodes. A level has been played few times, so
its learnability is the expectation of p (1 - p) under a Beta distribution.
"""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.tasks.episodes.levels import CHAIN

PRIOR = 0.5
"""Number of episodes that the success in drawn levels counts for in the estimate of a single level."""
HALF_LIFE = 2.0
"""Evidence counts half after so many levels have been played, for each level of the memory."""


class LearnableLevels:
    """The most learnable of the levels that were played, and what each world plays next.

    ``count`` takes the episodes that have ended, ``follow`` the worlds that have begun another level, and ``update``,
    between rollouts, makes use of both. A pickled copy goes on as the original does.

    Args:
        share: Share of the levels that are chosen from the memory; all others are drawn.
        size: Greatest number of levels in the memory.
        seed: Seed of the choices.

    Attributes:
        levels: Levels in the memory, the most learnable first, shape ``(n,)``.
        wins: Successes in each, where older ones count less, shape ``(n,)``.
        plays: Number of times that each was played, where older ones count less, shape ``(n,)``.
        learnability: Learnability of each, from 0 to 0.25, shape ``(n,)``.
        following: Level that each world begins next, -1 for one that is drawn, shape ``(n_worlds,)``.

    Raises:
        ValueError: If ``share`` is not between 0 and 1, or ``size`` is less than 1.
    """

    def __init__(self, n_worlds: int, *, share: float = 0.5, size: int = 1000, seed: int = 0) -> None:
        if not 0.0 <= share <= 1.0:
            raise ValueError(f"share must be from 0 to 1, got {share}")
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        self.share, self.size = share, size
        self.levels: Ints = np.zeros(0, np.int64)
        self.wins: Floats = np.zeros(0)
        self.plays: Floats = np.zeros(0)
        self.learnability: Floats = np.zeros(0)
        self.following: Ints = np.full(n_worlds, CHAIN)
        self._chosen: Ints = np.full(n_worlds, CHAIN)
        self._level: Ints = np.full(n_worlds, CHAIN)
        self._episodes: Floats = np.zeros((n_worlds, 2))
        self._drawn: Floats = np.zeros(2)
        self._played: list[tuple[int, float, bool]] = []
        self._random = np.random.default_rng(seed)

    @property
    def success(self) -> float:
        """Rate of success in drawn levels, where older ones count less; 0.5 before there are any."""
        wins, plays = self._drawn.tolist()
        return float((wins + 1.0) / (plays + 2.0))

    def count(self, world: int, level: int, success: float) -> None:
        """Note that an episode has ended: the only one of its level, or that of one robot of a team."""
        self._level[world] = level
        self._episodes[world, 0] += success
        self._episodes[world, 1] += 1.0

    def follow(self, worlds: Ints) -> Ints:
        """Note that worlds have begun the level that followed, and choose what follows now.

        The success in the level before is the mean over its episodes.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``.

        Returns:
            The level that each begins next, -1 for one that is drawn, shape ``(n,)``.
        """
        for w in worlds.tolist():
            wins, plays = self._episodes[w].tolist()
            if plays:
                level = int(self._level[w])
                self._played.append((level, wins / plays, level != self._chosen[w]))
        self._episodes[worlds] = 0.0
        self._chosen[worlds] = self.following[worlds]
        self.following[worlds] = self._choose(len(worlds))
        return self.following[worlds]

    def update(self) -> None:
        """Estimate learnability anew, and keep the most learnable levels."""
        if not self._played:
            return
        level, success, is_drawn = (np.array(column) for column in zip(*self._played, strict=True))
        self._played = []
        kept = 0.5 ** (len(level) / (HALF_LIFE * self.size))
        self._drawn = kept * self._drawn + [success[is_drawn].sum(), is_drawn.sum()]
        levels, place = np.unique(np.concatenate([self.levels, level]), return_inverse=True)
        wins, plays = np.zeros(len(levels)), np.zeros(len(levels))
        np.add.at(wins, place, np.concatenate([kept * self.wins, success]))
        np.add.at(plays, place, np.concatenate([kept * self.plays, np.ones(len(level))]))
        learnability = expected_learnability(wins, plays, self.success)
        best = np.argsort(-learnability, kind="stable")[: self.size]
        self.levels, self.wins, self.plays = levels[best], wins[best], plays[best]
        self.learnability = learnability[best]

    def _choose(self, count: int) -> Ints:
        """Return levels of the memory, each with a probability in proportion to its learnability; -1 for drawn ones."""
        chosen = np.full(count, CHAIN)
        if len(self.levels):
            # In proportion, not the best ones evenly: then the size of the memory hardly matters, and a level that
            # is nearly always solved is hardly played.
            again = np.flatnonzero(self._random.random(count) < self.share)
            ends = np.cumsum(self.learnability)
            rows = np.searchsorted(ends[:-1], self._random.random(len(again)) * ends[-1], side="right")
            chosen[again] = self.levels[rows]
        return chosen


def expected_learnability(wins: Floats, plays: Floats, success: float) -> Floats:
    """Return the expectation of p (1 - p), where p has a Beta distribution with ``PRIOR`` episodes as its prior.

    With a = PRIOR * success + wins and b = PRIOR * (1 - success) + losses, it is ab / ((a + b) (a + b + 1)).

    Args:
        wins: Successes in each level, shape ``(n,)``.
        plays: Number of times that each was played, shape ``(n,)``.
        success: Rate of success in all levels, between 0 and 1.
    """
    a, b = PRIOR * success + wins, PRIOR * (1.0 - success) + plays - wins
    return np.asarray(a * b / ((a + b) * (a + b + 1.0)))
