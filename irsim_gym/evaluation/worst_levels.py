"""Success on the worst levels: the conditional value at risk (CVaR) of success.

CVaR at a share is the mean over the worst share of all outcomes (Rockafellar and Uryasev 2000, Optimization of
conditional value-at-risk). For navigation it is the success on the levels where a policy succeeds least (Rutherford et
al. 2024, arXiv:2408.15099). Levels that are chosen and scored by the same episodes look worse than they are, wherever
something is drawn anew: a failure by chance counts, and no success by chance makes up for it. So they are chosen by one
half of the repetitions, and scored by the other half.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

WORST = MappingProxyType({"5 %": 0.05, "1 %": 0.01})
"""Shares of the levels that tables show, by their names."""


def worst_share(success: ArrayLike, share: float) -> float:
    """Return the success on the worst levels.

    They are chosen by one half of the repetitions and scored by the other, both ways round; the mean counts. Levels of
    the same success are chosen in the order of their numbers. A lone repetition chooses and scores: for a policy that
    draws nothing in a level without noise, a further one would be the same.

    Args:
        success: One row per repetition (seeds of one method, or episodes of one policy), one column per level.
        share: Which share of the levels, e.g. 0.05; at least one level is chosen.

    Returns:
        The success on them; NaN without levels.
    """
    rows = np.asarray(success, np.float64)
    if rows.size == 0:
        return math.nan
    count = max(1, math.ceil(share * rows.shape[1] - 1e-9))
    halves = (rows[::2].mean(axis=0), rows[1::2].mean(axis=0)) if len(rows) > 1 else (rows[0], rows[0])
    worst = [np.argsort(half, kind="stable")[:count] for half in halves]
    return float(0.5 * (halves[1][worst[0]].mean() + halves[0][worst[1]].mean()))


def worst_shares(success: ArrayLike) -> dict[str, float]:
    """Return the success on the worst levels for each share of ``WORST``, by its name."""
    return {name: worst_share(success, share) for name, share in WORST.items()}


def worst_of_policies(
    solved: Mapping[str, Sequence[bool]], seeds: Mapping[str, Sequence[str]]
) -> dict[str, dict[str, float]]:
    """Return the success on the worst levels of each policy, and of each method that has several.

    Args:
        solved: Success in each level, by policy.
        seeds: Names of its policies, for each method that has several.
    """
    own = {name: worst_shares([levels]) for name, levels in solved.items()}
    return own | {method: worst_shares([solved[name] for name in names]) for method, names in seeds.items()}
