"""Figures over seeds and levels, against hand calculations and normal theory."""

from __future__ import annotations

import math

import numpy as np
import pytest

from irsim_gym.evaluation.measures.statistics import (
    interquartile_mean,
    paired_difference,
    probability_of_improvement,
    stratified_mean,
)


def test_interquartile_mean_leaves_out_a_quarter_at_either_end() -> None:
    found = interquartile_mean([[0.0, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 100.0]])
    assert found.value == pytest.approx((2 + 3 + 4 + 5) / 4)
    assert found.low < found.value < found.high


def test_resampling_stays_within_tasks() -> None:
    """Runs of a task are alike, and tasks differ: the interval is a point, wide without strata."""
    found = stratified_mean([[0.1] * 5, [0.9] * 5])
    assert (found.value, found.low, found.high) == pytest.approx((0.5, 0.5, 0.5))


def test_intervals_are_those_of_normal_theory() -> None:
    values = np.random.default_rng(1).normal(3.0, 1.0, 400)
    half = 1.96 * values.std() / math.sqrt(400)
    found = paired_difference(values, np.zeros(400))
    assert found.value == pytest.approx(values.mean())
    assert (found.value - found.low, found.high - found.value) == pytest.approx((half, half), rel=0.1)


def test_probability_of_improvement_counts_pairs_and_half_of_draws() -> None:
    # Task 1: 3 > 1, 3 > 2, 2 > 1, 2 = 2: 3.5 of 4. Task 2: 0 of 4.
    found = probability_of_improvement([[3.0, 2.0], [0.0, 0.0]], [[1.0, 2.0], [1.0, 1.0]])
    assert found.value == pytest.approx((3.5 / 4 + 0.0) / 2)
    assert found.low <= found.value <= found.high
    with pytest.raises(ValueError, match="same tasks, got 1 and 2 tasks"):
        probability_of_improvement([[1.0]], [[1.0], [2.0]])


def test_a_lone_run_has_no_interval() -> None:
    found = interquartile_mean([[0.5]])
    assert found.value == 0.5
    assert math.isnan(found.low)
    assert math.isnan(found.high)


@pytest.mark.parametrize("scores", [[], [[]], [[[1.0]]]])
def test_scores_are_lists_by_task(scores: list[list[float]]) -> None:
    with pytest.raises(ValueError, match="one list of numbers for each task"):
        stratified_mean(scores)
