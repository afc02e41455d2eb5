"""orca, rvo and dwa that see what moves by their own scans, not by being told."""

from __future__ import annotations

import numpy as np
import pytest
from test_tracks import ROOM, mover, watch

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.tasks import Episodes

WORLD = np.zeros(1, np.int64)


def led(episodes: Episodes, name: str, n_steps: int = 40) -> np.ndarray:
    """Let a behaviour drive, and return the poses of the robot, ``(n_steps, 3)``."""
    policy, own = BehaviorPolicy(name), int(episodes.simulation.agents[0])
    policy.begin(episodes, WORLD, WORLD)
    poses = []
    for _ in range(n_steps):
        episodes.step(np.asarray(policy.act(episodes, WORLD)).reshape(1, 1, -1))
        poses.append(episodes.simulation.state.pose[0, own].copy())
    return np.array(poses)


@pytest.mark.parametrize("name", ["orca", "rvo", "dwa"])
def test_who_is_hidden_changes_nothing(name: str) -> None:
    wall = {"shape": {"name": "rectangle", "length": 0.2, "width": 6.0}, "state": [4, 5, 0]}
    ways = {
        options: [led(watch(mover(4.5, y, (4.5, 5)), obstacle=[ROOM, wall]), name + options) for y in (3.0, 7.0)]
        for options in (":sees=tracks", "")
    }
    assert np.array_equal(*ways[":sees=tracks"])
    assert np.array_equal(*ways[""]) == (name == "dwa")  # the others are told


@pytest.mark.parametrize("name", ["orca:sees=tracks", "rvo:sees=tracks", "dwa:sees=tracks", "dwa"])
def test_who_crosses_is_avoided_by_who_sees_it_move(name: str) -> None:
    poses = led(watch(mover(5, 8.2, (5, 0.5))), name, 60)
    person = np.column_stack([np.full(60, 5.0), np.maximum(8.2 - 0.1 * np.arange(1, 61), 0.5)])
    gap = np.hypot(*(poses[:, :2] - person).T).min() - 0.4
    assert (gap > 0.0) == (name != "dwa")  # which takes it for standing, and is run into


def test_a_scan_shows_no_roles() -> None:
    robot = {"behavior": {"name": "rvo", "sees": "tracks", "target_roles": "robot"}}
    with pytest.raises(IrsimGymError, match="must be 'all' with sees: tracks"):
        watch(robot=robot)
