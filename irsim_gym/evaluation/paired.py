"""Differences between policies that played the same levels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy import stats

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.evaluation.metrics import CONFIDENCE

RESAMPLES = 9999
BATCH = 250
"""Resamples that are drawn together: they bound the memory, and change nothing."""


@dataclass(frozen=True)
class Difference:
    """A mean difference over levels with its 95 % interval, from a paired bootstrap; NaN where one level is too few.

    Attributes:
        value: The mean.
        low: Lower end of the interval.
        high: Upper end of the interval.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class PairedComparison:
    """Two policies on the same levels.

    Attributes:
        one: Name of the first policy.
        other: Name of the second policy.
        only_one: Number of levels that only the first solved.
        only_other: Number of levels that only the second solved.
        success: Success of the first minus that of the second.
        spl: The same of the success weighted by path length.
        p: Of McNemar's exact test: how likely counts as unequal as these are if both solve equally many levels.
        p_adjusted: The same for all comparisons that are reported together (Benjamini and Hochberg 1995).
    """

    one: str
    other: str
    only_one: int
    only_other: int
    success: Difference
    spl: Difference
    p: float
    p_adjusted: float


def compare_pairs(policies: Sequence[str], success: Flags, spl: Floats) -> list[PairedComparison]:
    """Compare each policy with each one behind it.

    Args:
        policies: Their names.
        success: Which levels they solved, ``(n_policies, n_levels)``.
        spl: Success weighted by path length, ``(n_policies, n_levels)``.
    """
    found = [_compare(policies, success, spl, i, j) for i, j in combinations(range(len(policies)), 2)]
    adjusted = stats.false_discovery_control([pair.p for pair in found]) if found else []
    return [replace(pair, p_adjusted=float(p)) for pair, p in zip(found, adjusted, strict=True)]


def _compare(policies: Sequence[str], success: Flags, spl: Floats, i: int, j: int) -> PairedComparison:
    only_one, only_other = int((success[i] & ~success[j]).sum()), int((success[j] & ~success[i]).sum())
    differing = only_one + only_other
    p = float(stats.binomtest(only_one, differing).pvalue) if differing else 1.0
    solved = paired_difference(success[i].astype(np.float64), success[j].astype(np.float64))
    return PairedComparison(
        policies[i], policies[j], only_one, only_other, solved, paired_difference(spl[i], spl[j]), p, p
    )


def paired_difference(one: Floats, other: Floats) -> Difference:
    """Return the mean of ``one - other``, with an interval from levels drawn with replacement.

    Args:
        one: A value for each level, ``(n_levels,)``.
        other: The same of another policy, on the same levels.
    """
    apart = one - other
    if len(apart) < 2:
        return Difference(float(apart.mean()), math.nan, math.nan)
    found = stats.bootstrap(
        (apart,), np.mean, n_resamples=RESAMPLES, batch=BATCH, confidence_level=CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return Difference(float(apart.mean()), float(found.low), float(found.high))
