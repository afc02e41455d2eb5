"""Success on the worst levels: the conditional value at risk (CVaR) of success.

CVaR at a share is the mean over the worst share of all outcomes (Rockafellar and Uryasev 2000, Optimization of
conditional value-at-risk). In navigation, it is the success on the levels where a policy succeeds least (Rutherford et
al. 2024, arXiv:2408.15099). If the same episodes chose and scored the levels, the estimate would be biased low wherever
repetitions are random: failures by chance count, and no successes by chance offset them. Therefore one half of the
repetitions chooses the levels, and the other half scores them.
"""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

WORST = MappingProxyType({"5 %": 0.05, "1 %": 0.01})
"""Shares of the levels that tables show, by name."""


def worst_share(success: ArrayLike, share: float) -> float:
    """Return the success on the worst levels.

    One half of the repetitions chooses them and the other half scores them, then vice versa; the result is the mean.
    Among levels with equal success, lower numbers come first. A single repetition both chooses and scores: for a
    deterministic policy in levels without noise, further ones would be identical.

    Args:
        success: One row per repetition (seeds of one method, or episodes of one policy), one column per level.
        share: Share of the levels, e.g. 0.05; at least one level is chosen.

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
    """Return the success on the worst levels of each policy, and of each method with several policies.

    Args:
        solved: Success in each level, by policy.
        seeds: Names of the policies of each method that has several.
    """
    by_policy = {name: worst_shares([levels]) for name, levels in solved.items()}
    return by_policy | {method: worst_shares([solved[name] for name in names]) for method, names in seeds.items()}
