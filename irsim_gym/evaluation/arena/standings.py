"""The comparison of an arena's policies: figures, differences, success by difficulty."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Flags, Ints
from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.comparison.evaluate import Evaluation
from irsim_gym.evaluation.levels.played import QUARTER_NAMES
from irsim_gym.evaluation.measures.metrics import Rate, rate
from irsim_gym.evaluation.measures.paired import PairedComparison, compare_pairs

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


@dataclass(frozen=True)
class Standings:
    """The comparison of an arena's policies.

    Attributes:
        summaries: Figures of each policy; a ``TeamSummary`` for teams.
        pairs: Comparisons of each policy with each later one.
        strata_by: How the difficulty of levels is measured.
        strata: Success by difficulty, the easiest levels first.
    """

    summaries: list[Any]
    pairs: list[PairedComparison]
    strata_by: str
    strata: list[Stratum]

    def figures(self) -> dict[str, object]:
        """Return the comparisons by name, for a file."""
        strata = {"by": self.strata_by, "policies": [each.policy for each in self.summaries], "strata": self.strata}
        return {"pairs": self.pairs, "difficulty": strata}


def stand(evaluation: Evaluation) -> Standings:
    """Compare the policies of an evaluation."""
    board = Board.of(evaluation.rows)
    certificate, quarters = evaluation.level_set.certificate, evaluation.level_set.quarters
    if certificate is None or quarters is None:
        by, strata = PEERS, strata_of_peers(board)
    else:
        by = f"by how many of {', '.join(certificate.policies)} fail, in quarters"
        strata = strata_of_quarters(board, quarters)
    return Standings(evaluation.summaries, compare_pairs(list(evaluation.rows), board.success, board.spl), by, strata)


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
