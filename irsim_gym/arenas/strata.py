"""Success on easy and on hard levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from irsim_gym.arenas.board import Board
from irsim_gym.arraytypes import Flags, Ints
from irsim_gym.evaluation.metrics import Rate, rate
from irsim_gym.levels.played import QUARTER_NAMES

PEERS = "by how many of the other policies fail"


@dataclass(frozen=True)
class Stratum:
    """A group of levels of similar difficulty.

    Attributes:
        name: Name of the group.
        levels: Number of its levels for each policy, in the order of the board.
        success: Share of them that each policy solved.
    """

    name: str
    levels: tuple[int, ...]
    success: tuple[Rate, ...]


def strata_of_peers(board: Board) -> list[Stratum]:
    """Return success by the number of *other* policies that fail, from none to all of them.

    A policy's own failures do not count: otherwise every policy would do better on easy levels by definition.
    """
    failed = ~board.success
    others = failed.sum(axis=0) - failed
    most = len(board.policies) - 1
    return [_stratum(board, f"{k} of {most} fail", others == k) for k in range(most + 1)] if most else []


def strata_of_quarters(board: Board, quarter: Ints) -> list[Stratum]:
    """Return success by quarters of difficulty, the easiest first.

    Args:
        quarter: Quarter of each level, from 0 to 3, ``(n_levels,)``.
    """
    return [
        _stratum(board, name, np.broadcast_to(quarter == k, board.success.shape))
        for k, name in enumerate(QUARTER_NAMES)
    ]


def _stratum(board: Board, name: str, chosen: Flags) -> Stratum:
    solved, levels = (board.success & chosen).sum(axis=1), chosen.sum(axis=1)
    shares = tuple(rate(int(count), int(total)) for count, total in zip(solved, levels, strict=True))
    return Stratum(name, tuple(levels.tolist()), shares)
