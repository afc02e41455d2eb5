"""Statistics over several runs of a method: robust means, intervals, comparisons.

They follow Agarwal et al. 2021 (Deep reinforcement learning at the edge of the statistical precipice,
arXiv:2108.13264), with SciPy. A score is one number per run (a seed of a method) and task (a scenario). Resampling
draws runs within each task, so that every task keeps its weight.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.evaluation.measures.metrics import CONFIDENCE

RESAMPLES = 2000
CUT = 0.25
"""Share of the scores that an interquartile mean discards at either end."""
BLOCK = 2**22
"""Number of values that are resampled at a time."""

Scores = Sequence[ArrayLike]
"""One list of scores per task with one entry per run; tasks may have different numbers of runs."""


@dataclass(frozen=True)
class Estimate:
    """A figure with its bootstrap interval.

    Attributes:
        value: The figure.
        low: Lower end of the interval; NaN if there are too few scores for one.
        high: Upper end, likewise.
    """

    value: float
    low: float
    high: float


def interquartile_mean(scores: Scores) -> Estimate:
    """Return the mean of the middle half of all scores, with its stratified bootstrap interval."""
    from scipy.stats import trim_mean

    def middle(*samples: Floats, axis: int = -1) -> Any:
        return trim_mean(np.concatenate(samples, axis=axis), CUT, axis=axis)

    return _estimate(middle, _strata(scores))


def stratified_mean(scores: Scores) -> Estimate:
    """Return the mean over tasks of the mean over runs, with its stratified bootstrap interval."""
    return _estimate(_mean_of_means, _strata(scores))


def probability_of_improvement(first: Scores, second: Scores) -> Estimate:
    """Return the probability that a run of the first method beats a run of the second, averaged over tasks.

    A draw counts half (the Mann-Whitney statistic divided by the number of pairs).

    Args:
        first: One list of scores per task; higher is better.
        second: Likewise, for the same tasks.

    Raises:
        ValueError: If the methods have different numbers of tasks.
    """
    from scipy.stats import mannwhitneyu

    if len(first) != len(second):
        raise ValueError(f"both methods need scores of the same tasks, got {len(first)} and {len(second)} tasks")

    rank = partial(mannwhitneyu, method="asymptotic")  # its p value is not used

    def share(*samples: Floats, axis: int = -1) -> Any:
        pairs = zip(samples[: len(first)], samples[len(first) :], strict=True)
        won = [rank(a, b, axis=axis).statistic / (a.shape[axis] * b.shape[axis]) for a, b in pairs]
        return np.mean(won, axis=0)

    return _estimate(share, [*_strata(first), *_strata(second)])


def paired_difference(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Return the mean of first - second over levels that both played, with its bootstrap interval.

    Args:
        first: One number per level, such as its success.
        second: Likewise, of the same levels in the same order.

    Raises:
        ValueError: If the numbers of levels differ.
    """
    a, b = np.asarray(first, np.float64), np.asarray(second, np.float64)
    if a.shape != b.shape or a.ndim != 1:
        raise ValueError(f"both need one number for each level, got shapes {a.shape} and {b.shape}")
    return _estimate(_mean_of_means, [a - b])


def _strata(scores: Scores) -> list[Floats]:
    strata = [np.asarray(task, np.float64) for task in scores]
    if not strata or any(task.ndim != 1 or not task.size for task in strata):
        raise ValueError("scores are one list of numbers for each task, none of them empty")
    return strata


def _mean_of_means(*samples: Floats, axis: int = -1) -> object:
    return np.mean([sample.mean(axis=axis) for sample in samples], axis=0)


def _estimate(statistic: Callable[..., Any], samples: Sequence[Floats]) -> Estimate:
    """Return a statistic with its percentile interval; the resampling is seeded."""
    from scipy.stats import bootstrap

    value = float(statistic(*samples, axis=-1))
    if any(sample.size < 2 for sample in samples):
        return Estimate(value, math.nan, math.nan)
    interval = bootstrap(
        samples,
        statistic,
        n_resamples=RESAMPLES,
        batch=max(1, BLOCK // sum(sample.size for sample in samples)),
        vectorized=True,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(0),
    ).confidence_interval
    return Estimate(value, float(interval.low), float(interval.high))
