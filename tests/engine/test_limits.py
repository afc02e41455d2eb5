"""What a drive can execute of what it is asked, worked out by hand."""

from __future__ import annotations

import numpy as np

from irsim_gym.engine.command_limits import limit_velocity


def limited(worlds: list[int], fastest: list[list[float]], sharpest: list[list[float]], asked: float) -> np.ndarray:
    """Return the velocities of one body in three worlds, from rest, after a step of 0.1 s."""
    most, change = np.array(fastest)[:, None], np.array(sharpest)[:, None]
    present, stopped = np.ones((3, 1), np.bool_), np.zeros((3, 1), np.bool_)
    velocity, command = np.zeros((3, 1, 3)), np.full((3, 1, 3), asked)
    movers, driven = np.zeros(1, np.int64), np.ones(1, np.bool_)
    limits = -most, most, change
    limit_velocity(np.array(worlds), movers, np.array([0.1]), driven, *limits, present, stopped, command, velocity)
    return velocity[:, 0]


def test_each_world_has_limits_of_its_own() -> None:
    fastest = [[4.0, 4.0, 0.0], [2.5, 2.5, 0.0], [4.0, 4.0, 0.0]]
    sharpest = [[2.0, np.inf, 0.0], [30.0, 30.0, 0.0], [30.0, 2.0, 0.0]]
    expected = [[0.2, 4.0, 0.0], [2.5, 2.5, 0.0], [3.0, 0.2, 0.0]]
    np.testing.assert_allclose(limited([0, 1, 2], fastest, sharpest, 5.0), expected, atol=1e-15)


def test_worlds_share_what_has_one_row() -> None:
    expected = [[-0.2, -4.0, 0.0], [0.0, 0.0, 0.0], [-0.2, -4.0, 0.0]]
    found = limited([0, 2], [[4.0, 4.0, 0.0]], [[2.0, np.inf, 0.0]], -5.0)
    np.testing.assert_allclose(found, expected, atol=1e-15)
