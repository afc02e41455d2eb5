"""The memory of where bodies have been."""

from __future__ import annotations

import numpy as np

from irsim_gym.simulator.readings.trails import LONGEST, Trails


def noted(steps: list[int]) -> Trails:
    """One world whose body 1 of two stands at x = step."""
    trails = Trails(np.array([1]), 1)
    for step in steps:
        trails.record(np.zeros(1, np.int64), np.array([step]), np.array([[[-1.0, 0, 0], [step, 0, 0]]]))
    return trails


def test_poses_are_those_of_the_tracked_body_in_order() -> None:
    trails = noted([0, 1, 2, 3, 3, 7, 100])
    assert trails.poses(0, 0)[:, 0].tolist() == [0, 1, 2, 3, 7, 100]
    assert trails.poses(0, 0, every=2)[:, 0].tolist() == [0, 2, 100]
    assert trails.poses(0, 0, length=2)[:, 0].tolist() == [7, 100]


def test_a_step_count_that_goes_back_begins_anew() -> None:
    assert noted([0, 1, 2, 1]).poses(0, 0)[:, 0].tolist() == [1]


def test_the_latest_poses_stay() -> None:
    steps = noted(list(range(LONGEST + 5))).poses(0, 0)[:, 0]
    assert steps.tolist() == list(range(5, LONGEST + 5))


def test_poses_of_a_body_that_was_not_there_are_left_out() -> None:
    trails = noted([0])
    trails.record(np.zeros(1, np.int64), np.array([1]), np.full((1, 2, 3), np.nan))
    assert len(trails.poses(0, 0)) == 1
    trails.clear(np.array([0]))
    assert trails.poses(0, 0).shape == (0, 3)
