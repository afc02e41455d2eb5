"""Paired comparisons of policies that played the same levels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.evaluation.measures.statistics import Estimate, paired_difference


@dataclass(frozen=True)
class PairedComparison:
    """Two policies on the same levels.

    Attributes:
        one: Name of the first policy.
        other: Name of the second policy.
        only_one: Number of levels that only the first solved.
        only_other: Number of levels that only the second solved.
        success: Success of the first minus that of the second.
        spl: Success weighted by path length of the first minus that of the second.
        p: p value of McNemar's exact test: the probability of counts at least as unequal as these if both policies are
            equally good.
        p_adjusted: The p value, adjusted for all comparisons that are reported together (Benjamini and Hochberg 1995).
    """

    one: str
    other: str
    only_one: int
    only_other: int
    success: Estimate
    spl: Estimate
    p: float
    p_adjusted: float


def compare_pairs(policies: Sequence[str], success: Flags, spl: Floats) -> list[PairedComparison]:
    """Compare each policy with each later one.

    Args:
        policies: Their names.
        success: Which levels they solved, ``(n_policies, n_levels)``.
        spl: Success weighted by path length, ``(n_policies, n_levels)``.
    """
    from scipy.stats import false_discovery_control

    pairs = [_compare(policies, success, spl, i, j) for i, j in combinations(range(len(policies)), 2)]
    adjusted = false_discovery_control([pair.p for pair in pairs]) if pairs else []
    return [replace(pair, p_adjusted=float(p)) for pair, p in zip(pairs, adjusted, strict=True)]


def _compare(policies: Sequence[str], success: Flags, spl: Floats, i: int, j: int) -> PairedComparison:
    from scipy.stats import binomtest

    only_one, only_other = int((success[i] & ~success[j]).sum()), int((success[j] & ~success[i]).sum())
    differing = only_one + only_other
    p = float(binomtest(only_one, differing).pvalue) if differing else 1.0
    differences = paired_difference(success[i], success[j]), paired_difference(spl[i], spl[j])
    return PairedComparison(policies[i], policies[j], only_one, only_other, *differences, p, p)
