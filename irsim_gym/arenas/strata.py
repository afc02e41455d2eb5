"""Success on easy and on hard levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from irsim_gym.arenas.board import Board
from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.evaluation.metrics import Rate, rate

PEERS = "by how many of the other policies fail"
QUARTILES = "quartiles of the level set's difficulty"


@dataclass(frozen=True)
class Stratum:
    """Levels that are about equally hard.

    Attributes:
        name: What they are.
        levels: How many of them there are for each policy, in the order of the board.
        success: Share that each policy solved.
    """

    name: str
    levels: tuple[int, ...]
    success: tuple[Rate, ...]


def strata_of_peers(board: Board) -> list[Stratum]:
    """Return success by how many of the *other* policies fail, from none to all of them.

    A policy's own failures do not make a level hard for it: otherwise every policy would do better on easy levels by
    definition.
    """
    failed = ~board.success
    others = failed.sum(axis=0) - failed
    most = len(board.policies) - 1
    return [_stratum(board, f"{k} of {most} fail", others == k) for k in range(most + 1)] if most else []


def strata_of_difficulty(board: Board, difficulty: Floats) -> list[Stratum]:
    """Return success by quarters of the levels, the easiest first; equally hard ones by number.

    Args:
        board: The results.
        difficulty: Of each level, ``(n_levels,)``.
    """
    quarters = np.array_split(np.lexsort((board.levels, difficulty)), 4)
    found = []
    for number, quarter in enumerate(quarters, start=1):
        if len(quarter):
            chosen = np.zeros(board.success.shape, np.bool_)
            chosen[:, quarter] = True
            low, high = difficulty[quarter].min(), difficulty[quarter].max()
            found.append(_stratum(board, f"quarter {number}: {low:.3g} to {high:.3g}", chosen))
    return found


def _stratum(board: Board, name: str, chosen: Flags) -> Stratum:
    solved, levels = (board.success & chosen).sum(axis=1), chosen.sum(axis=1)
    shares = tuple(rate(int(count), int(total)) for count, total in zip(solved, levels, strict=True))
    return Stratum(name, tuple(levels.tolist()), shares)
